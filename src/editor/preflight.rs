//! Asks for a display, its libraries and a graphics adapter before Bevy does, which would panic.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Graphics interfaces that the editor draws with.
pub const BACKENDS: wgpu::Backends = wgpu::Backends::PRIMARY;

/// What the window system's client loads at run time, and the Debian package that has it.
#[cfg(target_os = "linux")]
const LIBRARIES: [(&str, &str); 6] = [
    ("libX11.so.6", "libx11-6"),
    ("libX11-xcb.so.1", "libx11-xcb1"),
    ("libXcursor.so.1", "libxcursor1"),
    ("libXi.so.6", "libxi6"),
    ("libxkbcommon.so.0", "libxkbcommon0"),
    ("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
];

/// What is missing, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Missing {
    #[error("no display: {0}")]
    Display(String),
    #[error("no {library} (Debian package {package})")]
    Library {
        library: &'static str,
        package: &'static str,
    },
    #[error(
        "no graphics adapter with Vulkan (a software one is enough: Debian package mesa-vulkan-drivers)"
    )]
    Adapter,
}

/// Whether the editor can open a window.
///
/// # Errors
/// The first thing that is missing.
pub fn window() -> Result<(), Missing> {
    display()?;
    adapter()
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
fn display() -> Result<(), Missing> {
    let has_wayland = std::env::var_os("WAYLAND_DISPLAY").is_some_and(|name| !name.is_empty());
    if cfg!(feature = "wayland") && has_wayland {
        return Ok(());
    }
    x11rb::connect(None).map_err(|error| {
        let reason = match std::env::var("DISPLAY") {
            Ok(name) if !name.is_empty() => format!("{name} does not answer ({error})"),
            _ => "DISPLAY is not set".to_owned(),
        };
        Missing::Display(reason)
    })?;
    for (library, package) in LIBRARIES {
        #[expect(
            unsafe_code,
            reason = "whether a library is there shows only in loading it"
        )]
        // SAFETY: these libraries' initialisers do nothing but set up their own tables, and
        // the window system's client loads the same ones later.
        let loaded = unsafe { libloading::Library::new(library) };
        loaded.map_err(|_| Missing::Library { library, package })?;
    }
    Ok(())
}

#[cfg(not(target_os = "linux"))]
fn display() -> Result<(), Missing> {
    Ok(())
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
            Missing::Library {
                library: "libXi.so.6",
                package: "libxi6",
            },
            Missing::Adapter,
        ] {
            assert!(!missing.to_string().contains('\n'), "{missing}");
        }
    }
}
