//! Chunks of other tools, which may be compressed.

use std::io::Read;

use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

/// What came out of a chunk.
pub(super) struct Unpacked {
    pub bytes: Vec<u8>,
    /// Why the rest could not be unpacked, if it could not.
    pub fault: Option<String>,
}

/// Unpacks the records of a chunk, up to `most` bytes and as far as they are sound; why nothing can be
/// unpacked.
pub(super) fn unpack(compression: &str, packed: &[u8], most: u64) -> Result<Unpacked, String> {
    let mut unpacked = Unpacked {
        bytes: Vec::new(),
        fault: None,
    };
    match compression {
        "" => unpacked.bytes.extend(packed),
        "lz4" => {
            let mut decoder = FrameDecoder::new(packed);
            // One frame after the other: each ends with a read of nothing.
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
                "it is compressed with `{other}`; this program reads lz4, zstd and what is not \
                 compressed"
            ));
        }
    }
    Ok(unpacked)
}

impl Unpacked {
    /// Takes all that a decoder has; whether that was all of it, and sound.
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
                self.fault = Some("it holds more than its head says".into());
                return false;
            }
        }
    }
}
