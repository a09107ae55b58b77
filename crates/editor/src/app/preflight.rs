//! Checks for a display, its libraries and a graphics adapter before Bevy does, which would panic.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Graphics interfaces that the editor draws with.
pub const BACKENDS: wgpu::Backends = wgpu::Backends::PRIMARY;

/// Whether a library that the window system's client loads at run time is there.
#[cfg(target_os = "linux")]
type Load = fn() -> bool;

/// Those libraries, and the Debian packages that have them.
#[cfg(target_os = "linux")]
const LIBRARIES: [(&str, &str, Load); 6] = [
    ("libX11", "libx11-6", || x11_dl::xlib::Xlib::open().is_ok()),
    ("libX11-xcb", "libx11-xcb1", || x11_dl::xlib_xcb::Xlib_xcb::open().is_ok()),
    ("libXcursor", "libxcursor1", || x11_dl::xcursor::Xcursor::open().is_ok()),
    ("libXi", "libxi6", || x11_dl::xinput2::XInput2::open().is_ok()),
    ("libxkbcommon", "libxkbcommon0", || xkbcommon_dl::xkbcommon_option().is_some()),
    ("libxkbcommon-x11", "libxkbcommon-x11-0", || {
        xkbcommon_dl::x11::xkbcommon_x11_option().is_some()
    }),
];

/// What is missing, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Missing {
    #[error("no display: {0}")]
    Display(String),
    #[error("no {library} (Debian package {package})")]
    Library { library: &'static str, package: &'static str },
    #[error(
        "no graphics adapter with Vulkan (a software one is enough: Debian package mesa-vulkan-drivers)"
    )]
    Adapter,
}

/// A display that answered; keep it until the window is closed.
///
/// An X server that loses its last client may start over and turn away whoever connects
/// meanwhile: this one stays a client while the window system connects.
pub struct Display {
    #[cfg(target_os = "linux")]
    _connection: Option<x11rb::rust_connection::RustConnection>,
}

/// Whether the editor can open a window.
///
/// # Errors
/// The first thing that is missing.
pub fn window() -> Result<Display, Missing> {
    let display = display()?;
    adapter()?;
    Ok(display)
}

/// Whether pictures can be made without a window.
///
/// # Errors
/// [`Missing::Adapter`].
pub fn adapter() -> Result<(), Missing> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = BACKENDS;
    let instance = wgpu::Instance::new(descriptor);
    // Outside the web the list is there at once.
    let adapters = ready(instance.enumerate_adapters(BACKENDS)).unwrap_or_default();
    if adapters.is_empty() {
        return Err(Missing::Adapter);
    }
    Ok(())
}

#[cfg(target_os = "linux")]
fn display() -> Result<Display, Missing> {
    let has_wayland = std::env::var_os("WAYLAND_DISPLAY").is_some_and(|name| !name.is_empty());
    if cfg!(feature = "wayland") && has_wayland {
        return Ok(Display { _connection: None });
    }
    let (connection, _) = x11rb::connect(None).map_err(|error| {
        let reason = match std::env::var("DISPLAY") {
            Ok(name) if !name.is_empty() => format!("{name} does not answer ({error})"),
            _ => "DISPLAY is not set".to_owned(),
        };
        Missing::Display(reason)
    })?;
    for (library, package, load) in LIBRARIES {
        if !load() {
            return Err(Missing::Library { library, package });
        }
    }
    Ok(Display { _connection: Some(connection) })
}

#[cfg(not(target_os = "linux"))]
fn display() -> Result<Display, Missing> {
    Ok(Display {})
}

fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_one_line_that_names_the_cure() {
        for missing in [
            Missing::Display("DISPLAY is not set".to_owned()),
            Missing::Library { library: "libXi", package: "libxi6" },
            Missing::Adapter,
        ] {
            assert!(!missing.to_string().contains('\n'), "{missing}");
        }
    }
}
