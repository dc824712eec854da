//! Date and time as text.

use std::time::SystemTime;

/// Returns a time as UTC to the minute, for example `2026-11-23 09:41 UTC`; a time before 1970 becomes the beginning
/// of 1970.
#[must_use]
pub fn utc(time: SystemTime) -> String {
    let since = time.duration_since(SystemTime::UNIX_EPOCH);
    in_words(since.map_or(0, |since| since.as_secs()))
}

/// Formats a time in seconds since 1970.
fn in_words(seconds: u64) -> String {
    let (mut days, of_day) = (seconds / 86_400, seconds % 86_400);
    let is_leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    let (hour, minute) = (of_day / 3600, of_day / 60 % 60);
    format!(
        "{year}-{month:02}-{:02} {hour:02}:{minute:02} UTC",
        days + 1
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_the_calendar() {
        assert_eq!(in_words(0), "1970-01-01 00:00 UTC");
        assert_eq!(in_words(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(in_words(951_868_800 - 60), "2000-02-29 23:59 UTC");
        assert_eq!(in_words(951_868_800), "2000-03-01 00:00 UTC");
        assert_eq!(in_words(1_798_761_599), "2026-12-31 23:59 UTC");
        assert_eq!(in_words(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
