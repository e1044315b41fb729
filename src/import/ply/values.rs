//! Reads the numbers behind a header.

use super::header::Scalar;

/// A sequence of numbers, in the file's order. Missing numbers are errors.
pub(super) trait Values {
    /// Begins an item of an element.
    fn begin(&mut self) -> Result<(), String>;
    /// Ends an item. Returns an error if the item has unread values.
    fn end(&mut self) -> Result<(), String>;
    fn number(&mut self, scalar: Scalar) -> Result<f64, String>;
    /// Skips `count` numbers.
    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), String>;
    /// Returns the line of the item in a text file.
    fn line(&self) -> Option<usize>;

    /// Reads the length of a list.
    fn count(&mut self, scalar: Scalar) -> Result<usize, String> {
        let count = self.number(scalar)?;
        if count < 0.0 { Err(format!("a list has a negative count, {count}")) } else { Ok(count as usize) }
    }
}

/// Body of a binary file.
pub(super) struct Binary<'a> {
    rest: &'a [u8],
    /// Whether the byte order is big-endian.
    is_big: bool,
}

impl<'a> Binary<'a> {
    pub(super) fn new(rest: &'a [u8], is_big: bool) -> Self {
        Self { rest, is_big }
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("the file ends before it")?;
        self.rest = rest;
        Ok(taken)
    }
}

impl Values for Binary<'_> {
    fn begin(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, String> {
        let bytes = self.take(scalar.size())?;
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        if self.is_big {
            word[..bytes.len()].reverse();
        }
        let bits = u64::from_le_bytes(word);
        Ok(match scalar {
            Scalar::I8 => (bits as i8).into(),
            Scalar::U8 => (bits as u8).into(),
            Scalar::I16 => (bits as i16).into(),
            Scalar::U16 => (bits as u16).into(),
            Scalar::I32 => (bits as i32).into(),
            Scalar::U32 => (bits as u32).into(),
            Scalar::F32 => f32::from_bits(bits as u32).into(),
            Scalar::F64 => f64::from_bits(bits),
        })
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), String> {
        let bytes = scalar.size().checked_mul(count).ok_or("the file ends before it")?;
        self.take(bytes).map(drop)
    }

    fn line(&self) -> Option<usize> {
        None
    }
}

/// Body of a text file, which has one line per item of an element.
pub(super) struct Text<'a> {
    rest: &'a [u8],
    item: &'a [u8],
    line: usize,
}

impl<'a> Text<'a> {
    /// `lines` is the number of the header's lines.
    pub(super) fn new(rest: &'a [u8], lines: usize) -> Self {
        Self { rest, item: &[], line: lines }
    }

    fn word(&mut self) -> Result<&'a str, String> {
        let start = self.item.trim_ascii_start();
        let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
        let (word, rest) = start.split_at(end);
        self.item = rest;
        match str::from_utf8(word) {
            Ok("") => Err("the line has too few values".into()),
            Ok(word) => Ok(word),
            Err(_) => Err(format!("'{}' is not a number", String::from_utf8_lossy(word))),
        }
    }
}

impl Values for Text<'_> {
    /// Moves to the next line that is not empty.
    fn begin(&mut self) -> Result<(), String> {
        loop {
            if self.rest.is_empty() {
                return Err("the file ends before it".into());
            }
            let end = self.rest.iter().position(|&byte| byte == b'\n' || byte == b'\r').unwrap_or(self.rest.len());
            let is_pair = self.rest[end..].starts_with(b"\r\n");
            (self.item, self.rest) =
                (&self.rest[..end], self.rest.get(end + 1 + usize::from(is_pair)..).unwrap_or(&[]));
            self.line += 1;
            if !self.item.trim_ascii().is_empty() {
                return Ok(());
            }
        }
    }

    fn end(&mut self) -> Result<(), String> {
        match self.item.trim_ascii() {
            [] => Ok(()),
            more => Err(format!("'{}' follows its last value", String::from_utf8_lossy(more))),
        }
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, String> {
        let word = self.word()?;
        let number = match scalar {
            // Parsing as f32 rounds once, as other readers do.
            Scalar::F32 => word.parse::<f32>().ok().map(f64::from),
            _ => word.parse::<f64>().ok(),
        };
        let number = number.ok_or_else(|| format!("'{word}' is not a number"))?;
        let is_whole = number.fract() == 0.0 && number.abs() <= f64::from(u32::MAX);
        if scalar.is_float() || is_whole { Ok(number) } else { Err(format!("'{word}' is not a whole number")) }
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Result<(), String> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }

    fn line(&self) -> Option<usize> {
        Some(self.line)
    }
}
