//! Values as bytes: little end first, one after the other, without names.

/// Collects values.
#[derive(Debug, Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// What was collected.
    pub fn finish(self) -> Vec<u8> {
        self.0
    }

    /// Adds a number.
    pub fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    /// Adds a number, all bits of it.
    pub fn f64(&mut self, value: f64) {
        self.bytes(&value.to_bits().to_le_bytes());
    }

    /// Adds a number, all bits of it.
    pub fn f32(&mut self, value: f32) {
        self.bytes(&value.to_bits().to_le_bytes());
    }

    /// Adds yes or no.
    pub fn bool(&mut self, value: bool) {
        self.0.push(value.into());
    }

    /// Adds bytes, without their number.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    /// Adds text.
    pub fn text(&mut self, text: &str) {
        self.length(text.len());
        self.bytes(text.as_bytes());
    }

    /// Adds how many values follow.
    pub fn length(&mut self, length: usize) {
        self.bytes(&(length as u64).to_le_bytes());
    }
}

/// Takes values in the order in which they were collected; `None` where there are no more, or none that makes sense.
#[derive(Debug)]
pub struct Reader<'bytes>(&'bytes [u8]);

impl<'bytes> Reader<'bytes> {
    /// Of what a [`Writer`] collected, or of anything else.
    pub fn new(bytes: &'bytes [u8]) -> Self {
        Self(bytes)
    }

    /// Nothing is left.
    pub fn is_at_end(&self) -> bool {
        self.0.is_empty()
    }

    /// How many bytes are left.
    pub fn left(&self) -> usize {
        self.0.len()
    }

    /// Bytes.
    pub fn bytes(&mut self, count: usize) -> Option<&'bytes [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    /// A number.
    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// A number.
    pub fn f64(&mut self) -> Option<f64> {
        self.array().map(u64::from_le_bytes).map(f64::from_bits)
    }

    /// A number that is neither infinite nor NaN.
    pub fn finite(&mut self) -> Option<f64> {
        self.f64().filter(|value| value.is_finite())
    }

    /// So many numbers that are neither infinite nor NaN.
    pub fn finites<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.finite()?;
        }
        Some(values)
    }

    /// Yes or no.
    pub fn bool(&mut self) -> Option<bool> {
        match self.array::<1>()? {
            [0] => Some(false),
            [1] => Some(true),
            _ => None,
        }
    }

    /// Text.
    pub fn text(&mut self) -> Option<String> {
        let length = self.length(1)?;
        String::from_utf8(self.bytes(length)?.to_vec()).ok()
    }

    /// How many values of at least `size` bytes follow; `None` where there are not so many left.
    pub fn length(&mut self, size: usize) -> Option<usize> {
        let length = usize::try_from(u64::from_le_bytes(self.array()?)).ok()?;
        (length.checked_mul(size)? <= self.0.len()).then_some(length)
    }
}
