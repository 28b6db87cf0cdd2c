//! Buffered input of bytes and words from a file of known length, which bounds all allocations.

use crate::load::error::LoadProblem;
use std::io::{self, BufRead};

pub(super) struct Input<R> {
    /// Bytes left in the file, by the length given.
    pub remaining: u64,
    reader: R,
    /// How the lines of the header end.
    line_end: LineEnd,
}

/// The terminator of lines.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LineEnd {
    Unknown,
    /// A line feed, also after a carriage return.
    Feed,
    /// A carriage return alone, as on old Macs.
    Return,
}

impl<R: BufRead> Input<R> {
    pub(super) fn new(reader: R, length: u64) -> Self {
        Self { remaining: length, reader, line_end: LineEnd::Unknown }
    }

    /// Reads a line without its terminator; `None` if the file ends first or the line is longer
    /// than `longest`. The first line ends with any terminator, all others with its kind: after the
    /// last, binary data may begin with a byte that looks like a line feed.
    pub(super) fn line(&mut self, longest: usize) -> Result<Option<Vec<u8>>, LoadProblem> {
        let mut line = Vec::new();
        let is_first = self.line_end == LineEnd::Unknown;
        loop {
            let Some(byte) = self.byte()? else { return Ok(None) };
            match byte {
                b'\r' if is_first => {
                    if self.at_hand()?.first() == Some(&b'\n') {
                        self.consume(1);
                        self.line_end = LineEnd::Feed;
                    } else {
                        self.line_end = LineEnd::Return;
                    }
                    return Ok(Some(line));
                }
                b'\r' if self.line_end == LineEnd::Return => return Ok(Some(line)),
                b'\n' if self.line_end != LineEnd::Return => {
                    self.line_end = LineEnd::Feed;
                    return Ok(Some(line));
                }
                _ if line.len() >= longest => return Ok(None),
                _ => line.push(byte),
            }
        }
    }

    /// Fills `bytes`; returns false if the file ends first.
    pub(super) fn bytes(&mut self, bytes: &mut [u8]) -> Result<bool, LoadProblem> {
        match self.reader.read_exact(bytes) {
            Ok(()) => {
                self.remaining = self.remaining.saturating_sub(bytes.len() as u64);
                Ok(true)
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
            Err(error) => Err(LoadProblem::Read { error }),
        }
    }

    /// Returns the buffered bytes, reading some if there are none; empty at the end of the file.
    pub(super) fn at_hand(&mut self) -> Result<&[u8], LoadProblem> {
        while let Err(error) = self.reader.fill_buf() {
            if error.kind() != io::ErrorKind::Interrupted {
                return Err(LoadProblem::Read { error });
            }
        }
        // The buffer is full, so this does not fail.
        Ok(self.reader.fill_buf().unwrap_or_default())
    }

    /// Skips buffered bytes.
    pub(super) fn consume(&mut self, count: usize) {
        self.reader.consume(count);
        self.remaining = self.remaining.saturating_sub(count as u64);
    }

    /// Reads the next word between white space into `word`; returns false if the file ends first.
    /// Longer words than any number are cut.
    pub(super) fn word(&mut self, word: &mut String) -> Result<bool, LoadProblem> {
        const LONGEST: usize = 400;
        word.clear();
        loop {
            match self.byte()? {
                None => return Ok(!word.is_empty()),
                Some(byte) if byte.is_ascii_whitespace() => {
                    if !word.is_empty() {
                        return Ok(true);
                    }
                }
                Some(byte) if word.len() < LONGEST => word.push(char::from(byte)),
                Some(_) => {}
            }
        }
    }

    fn byte(&mut self) -> Result<Option<u8>, LoadProblem> {
        let byte = self.at_hand()?.first().copied();
        if byte.is_some() {
            self.consume(1);
        }
        Ok(byte)
    }
}
