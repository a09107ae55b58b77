//! The layers of a view. The table of this file is all that is known of a layer but how it is drawn:
//! command line, files, slides, the window's list and its legend take it from here.

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

/// A layer as lists of layers have it.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// In files; with `-` for `_` on the command line.
    pub field: &'static str,
    /// In the window.
    pub label: &'static str,
    /// What it shows, in a sentence.
    pub about: &'static str,
    /// Whether it is on in a design whose file leaves it out. Files depend on it: it never changes.
    pub is_on_at_first: bool,
    /// Whether those who do not design tools see it on the first slide.
    pub is_for_audience: bool,
    /// Where it stands in lists and in the legend: a multiple of ten, so that there is room for what
    /// comes with a layer.
    pub order: u32,
    pub switch: fn(&mut Layers) -> &mut bool,
}

/// One row a layer, in the order in which they are listed: its constant, field and label, whether it is
/// on at first, for whom it is, and what it shows.
macro_rules! layers {
    ($($constant:ident $field:ident $label:literal $first:ident $audience:ident $about:literal)*) => {
        /// What is drawn; a layer that is off costs nothing. A file has those that are not as they
        /// are at first.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
        #[serde(default)]
        pub struct Layers {
            $(#[doc = $about] pub $field: bool,)*
        }

        #[allow(non_camel_case_types, reason = "named as the fields")]
        enum Row { $($field,)* }

        impl Layer {
            $(#[doc = $about] pub const $constant: Self = Self {
                field: stringify!($field),
                label: $label,
                about: $about,
                is_on_at_first: is_on!($first),
                is_for_audience: is_for_audience!($audience),
                order: 10 * (Row::$field as u32 + 1),
                switch: |layers| &mut layers.$field,
            };)*

            /// Every layer, in the order of its row.
            pub const ALL: &[Self] = &[$(Self::$constant,)*];
        }

        impl Default for Layers {
            /// The opening view: what is grasped in five seconds. Bodies and sensors have no layer.
            fn default() -> Self {
                Self { $($field: Layer::$constant.is_on_at_first,)* }
            }
        }
    };
}

macro_rules! is_on {
    (on) => {
        true
    };
    (off) => {
        false
    };
}

macro_rules! is_for_audience {
    (audience) => {
        true
    };
    (designers) => {
        false
    };
}

layers! {
    VOLUME volume "Volume" off designers
        "The tracker's measurement volume with its lengths, and the box that the room's model covers"
    GENERATOR generator "Field generator" off designers
        "The field generator at the origin of the tracker frame, with its coils where the room states them, and the tracker's axes"
    GRID grid "Ground grid" off designers
        "A grid on the ground, which shows distances at a glance"
    ANATOMY anatomy "Anatomy" on audience
        "The patient's anatomy, translucent, for orientation: no figure depends on it"
    SENSOR_ERRORS sensor_errors "Sensor errors" off designers
        "The position error of each sensor as an arrow, magnified"
    TIP_ERROR tip_error "Tip error" on audience
        "The error of the tip as an arrow, magnified, from where it is to where it is measured"
    REQUIREMENT requirement "Requirement at the tip" off audience
        "How far off the tip may be: a sphere around it, magnified like its error, which should end inside"
    GHOST ghost "Ghost" on audience
        "The tool where the tracker measures it, magnified as the errors are"
    MOTION motion "Range of motion" off designers
        "What the range of motion runs through, with balls that set where it ends"
    TIP_SCATTER tip_scatter "Tip scatter" off designers
        "Where the tracker's jitter puts the tip, magnified as the errors are"
    SLICE slice "Error slice" on designers
        "A plane through the room, coloured by its error or by the model validity"
    ARROWS arrows "Field arrows" off designers
        "Arrows on a lattice: direction and size of the field's position error in the room"
    PLACEMENT placement "Sensor placement" off designers
        "The body's surface, coloured by the tip error that the selected sensor would give there"
    MOUNTING mounting "Mounting regions" off audience
        "Where sensors may be mounted on the bodies, and where no coil may be: boxes and the tip's clearance"
    REGION region "Usable region" off audience
        "Where in the volume the design meets its requirement"
    SUPPORT support "Model support" off designers
        "Where in its box the room's model is valid, judged by its measurements"
    LABELS labels "Labels" on audience
        "Names, lengths and letters of axes beside what they belong to"
}

impl Layer {
    /// What a command line calls it.
    pub fn name(&self) -> String {
        self.field.replace('_', "-")
    }

    pub fn is_on(&self, mut layers: Layers) -> bool {
        *(self.switch)(&mut layers)
    }

    /// The names of all, for a help text.
    pub fn names() -> String {
        let names: Vec<_> = Self::ALL.iter().map(Self::name).collect();
        names.join(", ")
    }
}

impl Layers {
    /// Bodies and sensors only.
    pub fn none() -> Self {
        Self::where_on(|_| false)
    }

    /// Those of a list with commas, and no others; `all` and `none` stand for every layer and no
    /// layer.
    ///
    /// ```
    /// use trackwright_design::view::Layers;
    ///
    /// assert_eq!(Layers::named("slice, grid").unwrap().names(), ["grid", "slice"]);
    /// assert!(Layers::named("sliec").is_err());
    /// ```
    ///
    /// # Errors
    /// The first name that no layer has.
    pub fn named(list: &str) -> Result<Self, String> {
        let mut layers = Self::none();
        let names = list.split(',').map(str::trim);
        for name in names.filter(|name| !name.is_empty()) {
            match name {
                "all" => layers = Self::where_on(|_| true),
                "none" => layers = Self::none(),
                _ => match Layer::ALL.iter().find(|layer| layer.name() == name) {
                    Some(layer) => *(layer.switch)(&mut layers) = true,
                    None => return Err(format!("no layer {name}")),
                },
            }
        }
        Ok(layers)
    }

    /// The names of those that are on.
    pub fn names(self) -> Vec<String> {
        Layer::ALL.iter().filter(|layer| layer.is_on(self)).map(Layer::name).collect()
    }

    /// Without what only those understand who design the tool.
    #[must_use]
    pub fn for_audience(self) -> Self {
        Self::where_on(|layer| layer.is_for_audience && layer.is_on(self))
    }

    fn where_on(is_on: impl Fn(&Layer) -> bool) -> Self {
        let mut layers = Self::default();
        for layer in Layer::ALL {
            *(layer.switch)(&mut layers) = is_on(layer);
        }
        layers
    }
}

impl Serialize for Layers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let is_other = |layer: &&Layer| layer.is_on(*self) != layer.is_on_at_first;
        let others: Vec<&Layer> = Layer::ALL.iter().filter(is_other).collect();
        let mut fields = serializer.serialize_struct("Layers", others.len())?;
        for layer in others {
            fields.serialize_field(layer.field, &layer.is_on(*self))?;
        }
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_turned_on_by_their_names() {
        let every = Layers::named("all").unwrap();
        assert_eq!(every.names().join(", "), Layer::names());
        assert_eq!(Layers::named(&Layer::names()), Ok(every));
        for layer in Layer::ALL {
            assert_eq!(Layers::named(&layer.name()).unwrap().names(), [layer.name()]);
        }
        assert_eq!(Layers::named("all,none,"), Ok(Layers::none()));
        assert_eq!(Layers::named("sliec"), Err("no layer sliec".to_owned()));
    }

    #[test]
    fn the_opening_view_is_bodies_errors_and_a_slice() {
        let names = Layers::default().names();
        assert_eq!(names, ["anatomy", "tip-error", "ghost", "slice", "labels"]);
    }

    #[test]
    fn a_file_has_what_is_not_as_at_first() {
        let file = |layers: Layers| serde_json::to_value(layers).unwrap();
        assert_eq!(file(Layers::default()), serde_json::json!({}));
        for layer in Layer::ALL {
            let mut layers = Layers::default();
            *(layer.switch)(&mut layers) ^= true;
            let expected = serde_json::json!({layer.field: !layer.is_on_at_first});
            assert_eq!(file(layers), expected);
            assert_eq!(serde_json::from_value::<Layers>(expected).unwrap(), layers);
        }
    }
}
