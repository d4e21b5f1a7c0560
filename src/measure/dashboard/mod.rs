//! The dashboard: a folder of bench records as one self-contained page.

mod changes;
mod command;
mod history;
mod page;
mod series;

pub(crate) use history::History;
pub(crate) use page::page;
