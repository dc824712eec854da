//! Run files: the samples of a rendering.
//!
//! A run file is comma-separated UTF-8 text, readable by any CSV reader: a header on the first line, then one line
//! per sample. The last column, `palpate_run_1`, names the format and its version. Its field in the first row
//! contains the metadata, which are the configuration of the run, as a JSON object of strings on one line. In every
//! other row it is empty.
//!
//! ```text
//! t_s,force_n,phase,palpate_run_1
//! 0,0,free,"{""method"":""hfcr"",""period_s"":""0.01""}"
//! 0.01,0.4905,contact,
//! ```
//!
//! A run without samples has no row for its metadata, so it is not written. A file with only a header is readable,
//! with empty metadata.
//!
//! Numbers are written with the fewest digits that parse to the same bits. A missing value, NaN, is an empty field;
//! infinities are `inf` and `-inf`, so that a diverged run can be stored.

pub(crate) mod metadata;
mod read;
mod write;

pub use read::{Run, RunError, RunFault, read};
pub use write::{Cell, RunWriteError, RunWriter};

/// Prefix of the name of the last column, before the version.
const MARK: &str = "palpate_run_";
/// Version of the format that is written and read.
const VERSION: &str = "1";

#[cfg(test)]
mod tests {
    use super::*;

    const NO_METADATA: &[(&str, &str)] = &[];

    fn pairs(run: &Run) -> Vec<(&str, &str)> {
        run.metadata()
            .iter()
            .map(|(key, value)| (&key[..], &value[..]))
            .collect()
    }

    fn read_text(text: &str) -> Result<Run, RunError> {
        read(text.as_bytes(), "run.csv")
    }

    fn column(numbers: &[f64]) -> String {
        let mut writer = RunWriter::new(Vec::new(), NO_METADATA, &["x"]).unwrap();
        for &number in numbers {
            writer.row(&[number.into()]).unwrap();
        }
        String::from_utf8(writer.finish().unwrap()).unwrap()
    }

    #[test]
    fn a_run_reads_as_it_was_written() {
        let metadata = [
            ("method", "hfcr"),
            ("a scene = ", " a, \"b\"\r\nc "),
            ("note", ""),
        ];
        let mut writer =
            RunWriter::new(Vec::new(), &metadata, &["t_s", "force_n", "phase"]).unwrap();
        writer
            .row(&[0.0.into(), 0.1.into(), "free".into()])
            .unwrap();
        writer
            .row(&[0.01.into(), f64::NAN.into(), "# a,\"b\"\r\nc".into()])
            .unwrap();
        writer
            .row(&[0.02.into(), f64::NEG_INFINITY.into(), "".into()])
            .unwrap();
        let text = String::from_utf8(writer.finish().unwrap()).unwrap();
        assert_eq!(
            text,
            "t_s,force_n,phase,palpate_run_1\n\
             0,0.1,free,\"{\"\"method\"\":\"\"hfcr\"\",\
             \"\"a scene = \"\":\"\" a, \\\"\"b\\\"\"\\r\\nc \"\",\"\"note\"\":\"\"\"\"}\"\n\
             0.01,,\"# a,\"\"b\"\"\r\nc\",\n0.02,-inf,,\n"
        );
        let run = read_text(&text).unwrap();
        assert_eq!(pairs(&run), metadata);
        assert_eq!(run.columns(), ["t_s", "force_n", "phase"]);
        assert_eq!((run.len(), run.is_empty()), (3, false));
        assert_eq!(run.numbers("t_s").unwrap(), [0.0, 0.01, 0.02]);
        let force = run.numbers("force_n").unwrap();
        assert!(force[1].is_nan() && force[2] == f64::NEG_INFINITY);
        assert_eq!(run.texts("phase").unwrap(), ["free", "# a,\"b\"\r\nc", ""]);
    }

    #[test]
    fn a_column_of_missing_values_keeps_its_length() {
        let run = read_text(&column(&[f64::NAN, 1.0, f64::NAN])).unwrap();
        let read = run.numbers("x").unwrap();
        assert_eq!(read.len(), 3);
        assert!(read[0].is_nan() && read[2].is_nan());
    }

    #[test]
    fn empty_metadata_reads_back() {
        let text = column(&[1.0]);
        assert_eq!(text, "x,palpate_run_1\n1,{}\n");
        assert!(read_text(&text).unwrap().metadata().is_empty());
    }

    proptest::proptest! {
        #[test]
        fn every_number_reads_back_to_the_same_bits(first: u64, mut bits: Vec<u64>) {
            bits.push(first);
            let numbers: Vec<f64> = bits.iter().map(|&bits| f64::from_bits(bits)).collect();
            let read = read_text(&column(&numbers)).unwrap().numbers("x").unwrap();
            assert_eq!(read.len(), numbers.len());
            for (read, number) in read.iter().zip(&numbers) {
                assert!(read.to_bits() == number.to_bits() || (read.is_nan() && number.is_nan()));
            }
        }

        #[test]
        fn small_numbers_read_back_to_the_same_bits(bits in 0_u64..1 << 53, minus: bool) {
            let number = f64::from_bits(bits | u64::from(minus) << 63);
            let read = read_text(&column(&[number])).unwrap().numbers("x").unwrap();
            assert_eq!(read[0].to_bits(), number.to_bits());
        }

        #[test]
        fn every_text_reads_back(first: (String, String), mut texts: Vec<(String, String)>) {
            texts.push(first);
            let mut writer = RunWriter::new(Vec::new(), NO_METADATA, &["a", "b"]).unwrap();
            for (a, b) in &texts {
                writer.row(&[a.as_str().into(), b.as_str().into()]).unwrap();
            }
            let bytes = writer.finish().unwrap();
            let run = read(&bytes[..], "run.csv").unwrap();
            let a: Vec<&str> = texts.iter().map(|(a, _)| a.as_str()).collect();
            let b: Vec<&str> = texts.iter().map(|(_, b)| b.as_str()).collect();
            assert_eq!(run.texts("a").unwrap(), a);
            assert_eq!(run.texts("b").unwrap(), b);
        }

        #[test]
        fn every_receipt_reads_back_in_its_order_from_one_line(entries: Vec<(String, String)>) {
            let mut metadata: Vec<(&str, &str)> = Vec::new();
            for (key, value) in &entries {
                if !key.is_empty() && metadata.iter().all(|(other, _)| other != key) {
                    metadata.push((key, value));
                }
            }
            let mut writer = RunWriter::new(Vec::new(), &metadata, &["x"]).unwrap();
            writer.row(&[1.0.into()]).unwrap();
            let text = String::from_utf8(writer.finish().unwrap()).unwrap();
            assert_eq!(text.matches(['\n', '\r']).count(), 2);
            assert_eq!(pairs(&read_text(&text).unwrap()), metadata);
        }
    }
}
