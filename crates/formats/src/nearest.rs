//! Which known name a mistyped one was meant to be.

/// Characters of a name for each that may be wrong in it.
const CHARACTERS_AN_ERROR: usize = 3;

/// The known names nearest to one that is none of them, those at the same distance alike; none
/// where it is like no other.
pub(super) fn nearest<'a>(found: &str, known: &[&'a str]) -> Vec<&'a str> {
    let length = found.chars().count();
    let distance_of = |name: &str| -> Option<usize> {
        let longest = length.max(name.chars().count());
        let most = (longest / CHARACTERS_AN_ERROR).max(1);
        // One that is much longer is not near, and gets no table of its size.
        let difference = length.abs_diff(name.chars().count());
        if difference > most {
            return None;
        }
        Some(distance(found, name)).filter(|distance| *distance <= most)
    };
    let distances: Vec<_> = known.iter().map(|name| distance_of(name)).collect();
    let Some(least) = distances.iter().flatten().min() else {
        return Vec::new();
    };
    let each = known.iter().zip(&distances);
    each.filter(|(_, distance)| distance.as_ref() == Some(least)).map(|(name, _)| *name).collect()
}

/// Insertions, deletions, other letters and exchanges of two neighbours that make one name of the
/// other: the optimal string alignment distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    let mut last_letter = None;
    for (i, letter) in a.chars().enumerate() {
        let mut row = vec![i + 1];
        for j in 1..=b.len() {
            let replaced = last[j - 1] + usize::from(letter != b[j - 1]);
            let mut least = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            let is_exchange = j > 1 && letter == b[j - 2] && last_letter == Some(b[j - 1]);
            if is_exchange {
                least = least.min(before[j - 2] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
        last_letter = Some(letter);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_counted_by_hand() {
        for (a, b, expected) in [
            ("", "", 0),
            ("crf", "", 3),
            ("crf", "crf", 0),
            ("cfr", "crf", 1),
            ("moiton", "motion", 1),
            ("rsx", "rx", 1),
            ("kitten", "sitting", 3),
            ("ca", "abc", 3),
        ] {
            assert_eq!(distance(a, b), expected, "{a} {b}");
            assert_eq!(distance(b, a), expected, "{b} {a}");
        }
    }

    #[test]
    fn only_what_is_like_a_name_is_near_it() {
        let known = ["crf", "tool", "motion", "x", "rx", "position_rms"];
        assert_eq!(nearest("cfr", &known), ["crf"]);
        assert_eq!(nearest("postion_rsm", &known), ["position_rms"]);
        assert_eq!(nearest("xr", &known), ["x", "rx"]);
        assert_eq!(nearest("maker", &known), [""; 0]);
        assert_eq!(nearest(&"x".repeat(100_000), &known), [""; 0]);
    }
}
