//! What is not a number: refused with a reason, or handed on as what it is, and never a panic.

use super::prelude::*;
use trackwright_field::fit::FitError;
use trackwright_field::model::ModelError;
use trackwright_geometry::pose::pose_from_array;

const NAN: f64 = f64::NAN;
const INF: f64 = f64::INFINITY;

const NO_NUMBERS: [(&str, f64); 2] = [("NaN", NAN), ("infinity", INF)];

pub(super) fn family(_: Extent) -> Family {
    let mut family = Family::new(
        "not a number",
        "NaN and infinity in every input: refused with a reason where something is made to \
            last, propagated where it is computed once, never a panic and never a plausible \
            number.",
        &[],
    );
    for add in [models, evaluations, fits, frames] {
        add(&mut family);
    }
    for (name, value) in NO_NUMBERS {
        family.claim(
            format!("a rotation vector with {name}"),
            "the rotation is not a number",
            move |m| (m.exp)(&Vector3::new(0.1, value, 0.2)).quaternion().w.is_nan(),
        );
        family.claim(
            format!("a rotation matrix with {name}"),
            "the logarithm is not a number",
            move |m| {
                let mut matrix = Matrix3::identity();
                matrix[(0, 1)] = value;
                (m.log_matrix)(&matrix).iter().any(|v| v.is_nan())
            },
        );
        family.claim(format!("a pose with a quaternion of {name}"), "is no pose", move |_| {
            pose_from_array([0.0, 0.0, 0.0, value, 0.0, 0.0, 0.0]).is_none()
        });
        family.claim(format!("singular values with {name}"), "are not numbers", move |m| {
            let svd = (m.svd3)(&Matrix3::repeat(value));
            svd.singular_values.iter().any(|v| !v.is_finite())
        });
    }
    family.claim("statistics with NaN", "all figures are not numbers", |m| {
        (m.statistics)(&mut [1.0, NAN, 2.0])
            .is_some_and(|s| s.values().all(|(_, value)| value.is_nan()))
    });
    family.claim("statistics with infinity", "the largest is infinite", |m| {
        (m.statistics)(&mut [1.0, INF, 2.0]).is_some_and(|s| s.max() == INF && s.median() == 2.0)
    });
    family.claim("statistics of nothing", "there are none", |m| (m.statistics)(&mut []).is_none());
    family
}

fn models(family: &mut Family) {
    let made = |bounds: Bounds, value: f64| {
        DistortionModel::of_position(1, bounds, vec![[0.0, 0.0, value, 0.0, 0.0, 0.0]; 8])
    };
    for (name, value) in NO_NUMBERS {
        family.claim(format!("a model with a coefficient of {name}"), "refused", move |_| {
            matches!(made(cube([0.0; 3], 1.0), value), Err(ModelError::NotFinite(0)))
        });
        family.claim(format!("a model with a box of {name}"), "refused", move |_| {
            let bounds = Bounds::from(([0.0; 3], [1.0, value, 1.0]));
            matches!(made(bounds, 0.0), Err(ModelError::Bounds { .. }))
        });
    }
    family.claim("a model with a box wider than numbers", "refused", move |_| {
        let bounds = Bounds::from(([-1.5e308; 3], [1.5e308; 3]));
        matches!(made(bounds, 0.0), Err(ModelError::Bounds { .. }))
    });
}

fn evaluations(family: &mut Family) {
    let evaluated = |m: &Methods, p: [f64; 3], axis: [f64; 3], outside: OutsidePolicy| {
        let bounds = cube([-100.0; 3], 200.0);
        let model = model(3, DirectionSet::Fourteen, Weighting::Area, bounds, 1);
        model.ok().map(|model| {
            let axis = Unit::new_unchecked(Vector3::from(axis));
            (m.evaluate)(&model, &Point3::from(p), &axis, outside)
        })
    };
    let is_nan = |e: Option<PoseError>| e.is_some_and(|e| e.position_mm.iter().all(|v| v.is_nan()));
    for (name, outside) in
        [("clamped", OutsidePolicy::Clamp), ("extrapolated", OutsidePolicy::Extrapolate)]
    {
        family.claim(
            format!("the field at a position of NaN, {name}"),
            "the error is not a number",
            move |m| is_nan(evaluated(m, [0.0, NAN, 0.0], [0.0, 0.0, 1.0], outside)),
        );
    }
    for weighting in [Weighting::Area, Weighting::Gnomonic] {
        for outside in [OutsidePolicy::Clamp, OutsidePolicy::Extrapolate] {
            for (where_to, position, axis) in
                [("at", [NAN, 0.0, 0.0], [0.0, 0.6, 0.8]), ("along", [1.0; 3], [0.0, NAN, 0.8])]
            {
                family.claim(
                    format!("the field {where_to} NaN in batches, {outside:?}, {weighting:?}"),
                    "that error alone is not a number",
                    move |m| {
                        let found = by_all_ways(m, position, axis, outside, weighting);
                        found.is_some_and(|all| all.into_iter().all(|e| is_nan(Some(e))))
                    },
                );
            }
        }
    }
    family.claim("the field at infinity, clamped", "the error on the box's face", move |m| {
        let at = |x: f64| evaluated(m, [x, 0.0, 0.0], [0.0, 0.0, 1.0], OutsidePolicy::Clamp);
        at(INF).is_some() && at(INF) == at(100.0) && at(-INF) == at(-100.0)
    });
    family.claim("the field at infinity, extrapolated", "the error is not finite", move |m| {
        let e = evaluated(m, [INF, 0.0, 0.0], [0.0, 0.0, 1.0], OutsidePolicy::Extrapolate);
        e.is_some_and(|e| e.position_mm.iter().all(|v| !v.is_finite()))
    });
    for (name, axis) in [("NaN", [0.0, NAN, 1.0]), ("infinity", [0.0, INF, 1.0])] {
        family.claim(
            format!("the field along an axis of {name}"),
            "the error is not a number",
            move |m| is_nan(evaluated(m, [1.0; 3], axis, OutsidePolicy::Clamp)),
        );
        for weighting in [Weighting::Area, Weighting::Gnomonic] {
            family.claim(
                format!("{weighting:?} weights of an axis of {name}"),
                "the weights are not numbers",
                move |m| {
                    let axis = Unit::new_unchecked(Vector3::from(axis));
                    let w = (m.weights)(DirectionSet::FortyTwo, &axis, weighting);
                    w.weights.iter().any(|w| w.is_nan())
                },
            );
        }
    }
}

/// The answers of batches and of blended models at one pose, which is seen to among others that
/// are numbers and stay so.
fn by_all_ways(
    methods: &Methods,
    position: [f64; 3],
    axis: [f64; 3],
    outside: OutsidePolicy,
    weighting: Weighting,
) -> Option<Vec<PoseError>> {
    // Enough poses to fill the lanes of any machine.
    const POSES: usize = 13;
    const OWN: usize = 6;
    let bounds = cube([-100.0; 3], 200.0);
    let model = model(3, DirectionSet::Fourteen, weighting, bounds, 1).ok()?;
    let (p, axis) = (Point3::from(position), Unit::new_unchecked(Vector3::from(axis)));
    let mut positions = vec![Point3::origin(); POSES];
    let mut axes = vec![Vector3::z_axis(); POSES];
    (positions[OWN], axes[OWN]) = (p, axis);
    let mut all = (methods.evaluate_along)(&model, &p, &axis, outside);
    for answers in (methods.evaluate_together)(&model, &positions, &axes, outside) {
        let is_finite = |e: &PoseError| e.position_mm.iter().all(|v| v.is_finite());
        let others = answers.iter().enumerate().filter(|(i, _)| *i != OWN);
        if !others.into_iter().all(|(_, e)| is_finite(e)) {
            return None;
        }
        all.push(answers[OWN]);
    }
    Some(all)
}

/// Samples of a smooth field, one of them changed.
fn samples(change: impl Fn(&mut Sample)) -> SampleSet {
    let mut sequence = Sequence::new(81);
    let bounds = cube([-100.0; 3], 200.0);
    let mut samples: Vec<Sample> = (0..60)
        .map(|_| {
            Sample::new(
                sequence.point_in(&bounds),
                sequence.axis(),
                PoseError {
                    position_mm: sequence.vector(),
                    rotation_rad: sequence.vector() * 0.01,
                },
            )
        })
        .collect();
    change(&mut samples[17]);
    SampleSet { samples, has_rotations: true, ambiguous: 0 }
}

fn fits(family: &mut Family) {
    type Change = fn(&mut Sample);
    let changes: [(&str, Change); 6] = [
        ("a position of NaN", |s| s.position_mm.x = NAN),
        ("a position of infinity", |s| s.position_mm.z = INF),
        ("an error of NaN", |s| s.error.position_mm.y = NAN),
        ("an error of infinity", |s| s.error.rotation_rad.y = INF),
        ("an axis of NaN", |s| {
            s.axis = Unit::new_unchecked(Vector3::new(0.0, NAN, 1.0));
        }),
        ("an axis of length 0", |s| {
            s.axis = Unit::new_unchecked(Vector3::zeros());
        }),
    ];
    for (name, change) in changes {
        family.claim(format!("a fit to {name}"), "refused with the sample's number", move |m| {
            let settings = FitSettings::new(1, DirectionSet::Six);
            let found = (m.fit)(&samples(change), &settings, None);
            matches!(found, Err(FitError::NotFinite(17)))
        });
    }
    for (name, value) in [("NaN", NAN), ("infinity", INF), ("−1", -1.0)] {
        family.claim(format!("a fit with a ridge of {name}"), "refused", move |m| {
            let settings = FitSettings { ridge: value, ..FitSettings::new(1, DirectionSet::Six) };
            matches!((m.fit)(&samples(|_| ()), &settings, None), Err(FitError::Ridge(_)))
        });
        family.claim(format!("a fit with a cutoff of {name}"), "refused", move |m| {
            let settings = FitSettings { rcond: value, ..FitSettings::new(1, DirectionSet::Six) };
            matches!((m.fit)(&samples(|_| ()), &settings, None), Err(FitError::Rcond(_)))
        });
    }
    for (name, value) in NO_NUMBERS {
        family.claim(format!("least squares with {name}"), "refused, or not a number", move |m| {
            let mut rows = vec![vec![1.0, 2.0], vec![2.0, 1.0], vec![0.5, 3.0]];
            rows[1][0] = value;
            let solved = (m.solve)(&rows, &[[1.0; 6]; 3], 1e-10, 0.0);
            solved.map_or(true, |s| s.unknowns.iter().flatten().any(|v| !v.is_finite()))
        });
    }
}

fn frames(family: &mut Family) {
    let fitted = |m: &Methods, place: f64, weight_mm: f64| -> Pose {
        let mut sequence = Sequence::new(91);
        let sensors: Vec<_> = (0..4)
            .map(|_| Sensor::five_dof("", sequence.vector() * 50.0, sequence.axis()))
            .collect();
        let mut readings: Vec<_> = sensors
            .iter()
            .map(|s| Reading {
                position_mm: s.position_in_body,
                rotation: s.orientation.any_rotation(),
            })
            .collect();
        readings[2].position_mm.x = place;
        (m.frame)(&body_of(sensors), weight_mm, &readings, &Pose::identity()).tracker_from_body
    };
    let is_nan = |pose: &Pose| pose.translation.vector.iter().any(|v| !v.is_finite());
    for (name, value) in NO_NUMBERS {
        family.claim(
            format!("a frame from a reading of {name}"),
            "the pose is not finite",
            move |m| is_nan(&fitted(m, value, 100.0)),
        );
        family.claim(
            format!("a frame with a weight of {name}"),
            "the pose is not finite",
            move |m| {
                let pose = fitted(m, 0.0, value);
                is_nan(&pose) || pose.rotation.quaternion().w.is_nan()
            },
        );
    }
    family.claim("a frame from a reading turned by NaN", "the pose is not finite", move |m| {
        let nan = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(NAN, 0.0, 0.0, 0.0));
        let body = body_of([Sensor::six_dof("", Point3::origin(), UnitQuaternion::identity())]);
        let reading = Reading { position_mm: Point3::origin(), rotation: nan };
        let pose = (m.frame)(&body, 100.0, &[reading], &Pose::identity()).tracker_from_body;
        pose.rotation.quaternion().w.is_nan()
    });
}
