//! The layers of a view: their switches, and the names that a command line gives them.

use serde::{Deserialize, Serialize};

/// What is drawn; a layer that is off costs nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(default)]
pub struct Layers {
    /// Edges of the tracker's measurement volume.
    pub volume: bool,
    pub generator: bool,
    pub grid: bool,
    /// The head or whatever else the CRF's mesh shows beside the CRF itself.
    pub anatomy: bool,
    /// Error vector of each sensor.
    pub sensor_errors: bool,
    /// Error vector of the tip.
    pub tip_error: bool,
    /// The sphere that the tip's error vector should end in.
    pub requirement: bool,
    /// The tool as the tracker reports it.
    pub ghost: bool,
    /// What the tool's range of motion runs through.
    pub motion: bool,
    /// The ellipsoid that holds 95 % of where the tracker's jitter puts the tip.
    pub tip_scatter: bool,
    pub slice: bool,
    /// The field's error as arrows on a lattice.
    pub arrows: bool,
    /// The selected sensor's body painted by what the tip error would be with the sensor there.
    pub placement: bool,
    /// Where sensors of the bodies may be mounted, and where no coil may be.
    pub mounting: bool,
    /// Where the design meets its requirement.
    pub region: bool,
    /// Where the room's model is valid: the surface around it, and hatching on the slice.
    pub support: bool,
    pub labels: bool,
}

impl Default for Layers {
    /// The opening view: what is grasped in five seconds. Bodies and sensors have no layer.
    fn default() -> Self {
        Self {
            volume: false,
            generator: false,
            grid: false,
            anatomy: true,
            sensor_errors: false,
            tip_error: true,
            requirement: false,
            ghost: true,
            motion: false,
            tip_scatter: false,
            slice: true,
            arrows: false,
            placement: false,
            mounting: false,
            region: false,
            support: false,
            labels: true,
        }
    }
}

/// A layer's switch.
type Switch = fn(&mut Layers) -> &mut bool;

/// Every layer, in the order in which they are listed to a person.
const NAMES: [(&str, Switch); 17] = [
    ("volume", |l| &mut l.volume),
    ("generator", |l| &mut l.generator),
    ("grid", |l| &mut l.grid),
    ("anatomy", |l| &mut l.anatomy),
    ("sensor-errors", |l| &mut l.sensor_errors),
    ("tip-error", |l| &mut l.tip_error),
    ("requirement", |l| &mut l.requirement),
    ("ghost", |l| &mut l.ghost),
    ("motion", |l| &mut l.motion),
    ("tip-scatter", |l| &mut l.tip_scatter),
    ("slice", |l| &mut l.slice),
    ("arrows", |l| &mut l.arrows),
    ("placement", |l| &mut l.placement),
    ("mounting", |l| &mut l.mounting),
    ("region", |l| &mut l.region),
    ("support", |l| &mut l.support),
    ("labels", |l| &mut l.labels),
];

impl Layers {
    /// Bodies and sensors only.
    pub fn none() -> Self {
        Self::every(false)
    }

    fn every(is_on: bool) -> Self {
        let mut layers = Self::default();
        for (_, switch) in NAMES {
            *switch(&mut layers) = is_on;
        }
        layers
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
                "all" => layers = Self::every(true),
                "none" => layers = Self::none(),
                _ => match NAMES.iter().find(|(own, _)| *own == name) {
                    Some((_, switch)) => *switch(&mut layers) = true,
                    None => return Err(format!("no layer {name}")),
                },
            }
        }
        Ok(layers)
    }

    /// What a design's file calls the layers.
    pub fn fields() -> Vec<String> {
        let fields = NAMES.iter().map(|(own, _)| own.replace('-', "_"));
        fields.collect()
    }

    /// The names of those that are on.
    pub fn names(&self) -> Vec<&'static str> {
        let mut layers = *self;
        let on = NAMES.iter().filter(|(_, switch)| *switch(&mut layers));
        on.map(|(name, _)| *name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_turned_on_by_their_names() {
        let every = Layers::named("all").unwrap();
        assert_eq!(every.names(), NAMES.map(|(name, _)| name));
        assert_eq!(Layers::named(&every.names().join(", ")), Ok(every));
        for (name, _) in NAMES {
            assert_eq!(Layers::named(name).unwrap().names(), [name]);
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
    fn the_fields_of_a_file_are_known_and_no_others() {
        let file = serde_json::to_value(Layers::every(true)).unwrap();
        let fields = file.as_object().unwrap();
        assert_eq!(fields.len(), NAMES.len());
        assert!(fields.keys().all(|field| Layers::fields().contains(field)));
    }
}
