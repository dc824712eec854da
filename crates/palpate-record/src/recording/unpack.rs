//! Decompression of chunks written by other tools.

use std::io::Read;

use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

/// Content of a decompressed chunk.
pub(super) struct Unpacked {
    pub bytes: Vec<u8>,
    /// Reason why the rest could not be decompressed, if any.
    pub fault: Option<String>,
}

/// Decompresses the records of a chunk, up to `most` bytes and up to the first error; returns the reason if nothing
/// can be decompressed.
pub(super) fn unpack(compression: &str, packed: &[u8], most: u64) -> Result<Unpacked, String> {
    let mut unpacked = Unpacked {
        bytes: Vec::new(),
        fault: None,
    };
    match compression {
        "" => unpacked.bytes.extend(packed),
        "lz4" => {
            let mut decoder = FrameDecoder::new(packed);
            // Decode frame by frame: each ends with an empty read.
            while !decoder.get_ref().is_empty() && unpacked.take(&mut decoder, most) {}
        }
        "zstd" => {
            let mut rest = packed;
            while !rest.is_empty() {
                match StreamingDecoder::new(&mut rest) {
                    Ok(mut decoder) => {
                        if !unpacked.take(&mut decoder, most) {
                            break;
                        }
                    }
                    Err(error) => {
                        unpacked.fault = Some(error.to_string());
                        break;
                    }
                }
            }
        }
        other => {
            return Err(format!(
                "its compression is `{other}`; this program reads lz4, zstd and uncompressed chunks"
            ));
        }
    }
    Ok(unpacked)
}

impl Unpacked {
    /// Reads a decoder to its end; returns whether it was complete and valid.
    fn take(&mut self, decoder: &mut impl Read, most: u64) -> bool {
        let mut piece = vec![0; 1 << 16];
        loop {
            match decoder.read(&mut piece) {
                Ok(0) => return true,
                Ok(taken) => self.bytes.extend(&piece[..taken]),
                Err(error) => {
                    self.fault = Some(error.to_string());
                    return false;
                }
            }
            if self.bytes.len() as u64 > most {
                self.fault = Some("it is longer than its header states".into());
                return false;
            }
        }
    }
}
