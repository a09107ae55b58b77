//! What all drags in the scene share: when one begins, how Shift slows it down, what Ctrl and Alt
//! do.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

/// A press that moves less than this is a click.
pub const DEAD_ZONE_PX: f32 = 3.0;

/// With Shift the pointer counts for this much.
const FINE: f32 = 0.1;

/// The pointer as it counts: slowed down while Shift is held, without a jump when it is pressed
/// or let go.
#[derive(Clone, Copy, Debug)]
pub struct FinePointer {
    is_fine: bool,
    /// Where the pointer and its effect were when that began.
    since: Vec2,
    effective: Vec2,
}

impl FinePointer {
    pub fn new(at: Vec2) -> Self {
        Self { is_fine: false, since: at, effective: at }
    }

    /// Where the pointer counts to be.
    pub fn at(&mut self, at: Vec2, is_fine: bool) -> Vec2 {
        if is_fine != self.is_fine {
            self.effective = self.effect_at(at);
            self.since = at;
            self.is_fine = is_fine;
        }
        self.effect_at(at)
    }

    fn effect_at(&self, at: Vec2) -> Vec2 {
        self.effective + (at - self.since) * if self.is_fine { FINE } else { 1.0 }
    }
}

/// The keys that change what a drag does.
#[derive(SystemParam)]
pub struct DragKeys<'w> {
    keys: Option<Res<'w, ButtonInput<KeyCode>>>,
}

impl DragKeys<'_> {
    pub fn is_fine(&self) -> bool {
        self.is_held([KeyCode::ShiftLeft, KeyCode::ShiftRight])
    }

    pub fn is_snapping(&self) -> bool {
        self.is_held([KeyCode::ControlLeft, KeyCode::ControlRight])
    }

    /// Off the surface.
    pub fn is_off(&self) -> bool {
        self.is_held([KeyCode::AltLeft, KeyCode::AltRight])
    }

    fn is_held(&self, either: [KeyCode; 2]) -> bool {
        self.keys.as_ref().is_some_and(|keys| keys.any_pressed(either))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shift_slows_the_pointer_down_without_a_jump() {
        let mut pointer = FinePointer::new(Vec2::ZERO);
        assert_eq!(pointer.at(Vec2::new(10.0, 0.0), false), Vec2::new(10.0, 0.0));
        assert_eq!(pointer.at(Vec2::new(10.0, 0.0), true), Vec2::new(10.0, 0.0));
        assert_eq!(pointer.at(Vec2::new(20.0, 0.0), true), Vec2::new(11.0, 0.0));
        assert_eq!(pointer.at(Vec2::new(30.0, 0.0), false), Vec2::new(12.0, 0.0));
        assert_eq!(pointer.at(Vec2::new(31.0, 0.0), false), Vec2::new(13.0, 0.0));
    }
}
