//! A tunnel in front of the viewer, as of SSH, that can be cut.

use anyhow::Result;
use std::io;
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// A listener that passes bytes on in both directions.
#[derive(Debug)]
pub(crate) struct Proxy {
    /// Where it listens.
    pub(crate) port: u16,
    open: Arc<Mutex<Vec<TcpStream>>>,
}

impl Proxy {
    /// Starts a tunnel to a port of this machine.
    pub(crate) fn start(port: u16) -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let own = listener.local_addr()?.port();
        let open = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&open);
        thread::spawn(move || {
            for incoming in listener.incoming().flatten() {
                // A connection that fails is the browser's to open again.
                let _ = join(incoming, port, &kept);
            }
        });
        Ok(Self { port: own, open })
    }

    /// Cuts all connections.
    pub(crate) fn cut(&self) {
        for stream in self.open.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

fn join(near: TcpStream, port: u16, open: &Mutex<Vec<TcpStream>>) -> Result<()> {
    let far = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
    let mut streams = open.lock().unwrap_or_else(PoisonError::into_inner);
    streams.extend([near.try_clone()?, far.try_clone()?]);
    for (mut from, mut to) in [(near.try_clone()?, far.try_clone()?), (far, near)] {
        thread::spawn(move || {
            let _ = io::copy(&mut from, &mut to);
            let _ = to.shutdown(Shutdown::Both);
        });
    }
    Ok(())
}
