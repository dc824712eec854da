//! Encoding of messages: little-endian CDR, as in ROS 2.
//!
//! A mark of four bytes identifies the encoding. Each following number is aligned to a multiple of its size, counted
//! from the end of the mark. A text consists of its length, including a closing 0, the text and that 0.

/// Little-endian CDR without options.
const MARK: [u8; 4] = [0, 1, 0, 0];

/// Writer of the fields of one message.
pub(super) struct Writer<'a> {
    bytes: &'a mut Vec<u8>,
    start: usize,
}

impl<'a> Writer<'a> {
    pub fn begin(bytes: &'a mut Vec<u8>) -> Self {
        bytes.extend(MARK);
        let start = bytes.len();
        Self { bytes, start }
    }

    pub fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    pub fn u32(&mut self, value: u32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    pub fn u64(&mut self, value: u64) {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
    }

    /// Writes a text up to its first NUL, because the encoding cannot contain one.
    pub fn text(&mut self, text: &str) {
        let text = text.split('\0').next().unwrap_or_default();
        let length = u32::try_from(text.len() + 1).expect("the writer refuses long texts");
        self.u32(length);
        self.bytes.extend(text.as_bytes());
        self.u8(0);
    }

    fn align(&mut self, size: usize) {
        let at = self.bytes.len() - self.start;
        let padded = self.start + at.next_multiple_of(size);
        self.bytes.resize(padded, 0);
    }
}

/// Reader of the fields of one message.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    pub fn begin(message: &'a [u8]) -> Option<Self> {
        let bytes = message.strip_prefix(&MARK)?;
        Some(Self { bytes, at: 0 })
    }

    pub fn u8(&mut self) -> Option<u8> {
        self.take::<1>().map(|[byte]| byte)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub fn text(&mut self) -> Option<&'a str> {
        let length = usize::try_from(self.u32()?).ok()?;
        let end = self.at.checked_add(length)?;
        let text = self.bytes.get(self.at..end)?.strip_suffix(&[0])?;
        self.at = end;
        std::str::from_utf8(text).ok()
    }

    /// Skips a number of `size` bytes.
    pub fn skip(&mut self, size: usize) -> Option<()> {
        let end = self.at.next_multiple_of(size).checked_add(size)?;
        self.bytes.get(..end)?;
        self.at = end;
        Some(())
    }

    pub fn is_at_end(&self) -> bool {
        self.at == self.bytes.len()
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let start = self.at.next_multiple_of(N);
        let bytes = self.bytes.get(start..start + N)?;
        self.at = start + N;
        bytes.try_into().ok()
    }
}
