//! The dashboard: what a folder of bench records tells, as one page that needs nothing else.

mod changes;
mod command;
mod history;
mod page;
mod series;

pub(crate) use history::History;
pub(crate) use page::page;
