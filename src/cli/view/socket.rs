//! The WebSocket of a page.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::thread;

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Message, WebSocket};

use super::client::Client;
use super::hub::Hub;

/// Most bytes of a message from a page.
const MOST: usize = 16 << 10;

/// One direction of a stream, since tungstenite wants both: the other one is empty.
struct Half<const READS: bool>(TcpStream);

impl<const READS: bool> Read for Half<READS> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if READS { self.0.read(bytes) } else { Err(ErrorKind::WouldBlock.into()) }
    }
}

impl<const READS: bool> Write for Half<READS> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // The writing half answers pings.
        if READS { Ok(bytes.len()) } else { self.0.write(bytes) }
    }

    fn flush(&mut self) -> io::Result<()> {
        if READS { Ok(()) } else { self.0.flush() }
    }
}

/// Reads what a page asks for until its connection ends. Another thread writes pictures. `rest` has arrived already.
pub(super) fn attend(stream: TcpStream, rest: Vec<u8>, hub: &Hub) -> io::Result<()> {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MOST))
        .max_frame_size(Some(MOST))
        .read_buffer_size(MOST);
    let (client, write) = (Arc::new(Client::default()), stream.try_clone()?);
    let mut reads = WebSocket::from_partially_read(
        Half::<true>(stream.try_clone()?),
        rest,
        Role::Server,
        Some(config),
    );
    let mut writes = WebSocket::from_raw_socket(Half::<false>(write), Role::Server, Some(config));
    let writer = Arc::clone(&client);
    thread::Builder::new().name("pictures".to_owned()).spawn(move || {
        while let Some(message) = writer.next() {
            if writes.send(message).is_err() {
                break;
            }
        }
        let _ = writes.send(Message::Close(None));
        let _ = writes.get_ref().0.shutdown(Shutdown::Both);
        writer.end();
    })?;
    hub.join(&client);
    while let Ok(message) = reads.read() {
        match message {
            Message::Text(text) => match serde_json::from_str(&text) {
                Ok(ask) => client.ask(ask),
                Err(_) => break,
            },
            Message::Ping(bytes) => {
                client.pong(bytes);
                continue;
            }
            Message::Pong(_) => continue,
            Message::Binary(_) | Message::Close(_) | Message::Frame(_) => break,
        }
        hub.wake();
    }
    client.end();
    hub.wake();
    stream.shutdown(Shutdown::Both)
}
