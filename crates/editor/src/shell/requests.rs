//! Requests that panels write: the message, and the frame that shows what comes of it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::window::RequestRedraw;

/// Writes messages of one kind, each with a redraw.
#[derive(SystemParam)]
pub struct Requests<'w, 's, T: Message> {
    messages: MessageWriter<'w, T>,
    // Writers of redraws would exclude each other where a panel has more than one of these.
    commands: Commands<'w, 's>,
}

impl<T: Message> Requests<'_, '_, T> {
    pub fn write(&mut self, request: T) {
        self.messages.write(request);
        self.commands.write_message(RequestRedraw);
    }

    pub fn write_all(&mut self, requests: impl IntoIterator<Item = T>) {
        for request in requests {
            self.write(request);
        }
    }
}
