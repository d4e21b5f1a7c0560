//! Clients: what a page asks for, and the newest picture for it.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use tungstenite::{Bytes, Message};

use super::message::Ask;

/// Requests that may wait. A page that sends more waits, too.
const WAITING: usize = 256;
/// Most pictures that are sent and not shown yet. The page reports each picture that it has shown.
const UNDERWAY: u32 = 2;

/// A page.
#[derive(Debug, Default)]
pub(super) struct Client {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    asked: VecDeque<Ask>,
    /// The next message. A newer one replaces it.
    message: Option<Vec<u8>>,
    /// Answer to the client's last ping.
    pong: Option<Bytes>,
    underway: u32,
    /// Whether the connection is over, or has to be after the last message.
    is_over: bool,
}

impl Client {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the page asked for since the last call.
    pub(super) fn take_asked(&self) -> Vec<Ask> {
        let asked = self.state().asked.drain(..).collect();
        self.changed.notify_all();
        asked
    }

    /// Whether the page asked for something that is not taken yet.
    pub(super) fn has_asked(&self) -> bool {
        !self.state().asked.is_empty()
    }

    /// Whether the page is ready for a picture.
    pub(super) fn is_ready(&self) -> bool {
        let state = self.state();
        state.underway < UNDERWAY && state.message.is_none()
    }

    pub(super) fn is_over(&self) -> bool {
        self.state().is_over
    }

    /// Sends a picture, instead of an earlier one that waits.
    pub(super) fn send(&self, message: Vec<u8>) {
        self.state().message = Some(message);
        self.changed.notify_all();
    }

    /// Answers a ping.
    pub(super) fn pong(&self, bytes: Bytes) {
        self.state().pong = Some(bytes);
        self.changed.notify_all();
    }

    /// Ends the connection, after the message that waits.
    pub(super) fn end(&self) {
        self.state().is_over = true;
        self.changed.notify_all();
    }

    /// The next message to write; `None` at the end.
    pub(super) fn next(&self) -> Option<Message> {
        let mut state = self.state();
        loop {
            if let Some(pong) = state.pong.take() {
                return Some(Message::Pong(pong));
            }
            if state.underway < UNDERWAY
                && let Some(message) = state.message.take()
            {
                state.underway += 1;
                return Some(Message::Binary(message.into()));
            }
            if state.is_over {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Notes what the page asks for. Waits if too much waits already.
    pub(super) fn ask(&self, ask: Ask) {
        let mut state = self.state();
        if matches!(ask, Ask::Shown) {
            state.underway = state.underway.saturating_sub(1);
            self.changed.notify_all();
            return;
        }
        while state.asked.len() >= WAITING && !state.is_over {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.asked.push_back(ask);
    }
}
