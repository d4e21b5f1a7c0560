//! Real time: what a camera sees while somebody moves it, and what it sees more and more clearly at rest.

mod camera;
mod fade;
mod history;
mod memory;
mod pace;
mod paint;
mod view;

pub(crate) use camera::Move;
pub(crate) use memory::keep_what_is_freed;
pub(crate) use view::{Picture, Turn, View};
