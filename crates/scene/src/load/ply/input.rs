//! Buffered input of bytes and words from a file of known length, which bounds all allocations.

use crate::load::error::LoadProblem;
use std::io::{self, BufRead};

pub(super) struct Input<R> {
    /// Bytes left in the file, by the length given.
    pub remaining: u64,
    reader: R,
}

impl<R: BufRead> Input<R> {
    pub(super) fn new(reader: R, length: u64) -> Self {
        Self { remaining: length, reader }
    }

    /// Reads a line without its terminator; `None` if the file ends first or the line is longer
    /// than `longest`.
    pub(super) fn line(&mut self, longest: usize) -> Result<Option<Vec<u8>>, LoadProblem> {
        let mut line = Vec::new();
        loop {
            let Some(byte) = self.byte()? else { return Ok(None) };
            match byte {
                b'\n' => return Ok(Some(line)),
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
