use super::*;
use std::fmt::Write as _;
use std::io::Cursor;

/// Names and data, by the programs of others.
const SAMPLES: &str = include_str!("tests/samples.txt");

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|k| u8::from_str_radix(&hex[k..k + 2], 16).expect("hex")).collect()
}

fn samples() -> impl Iterator<Item = (&'static str, Vec<u8>)> {
    let samples = SAMPLES.lines().filter_map(|line| line.split_once(' ')).filter(|(name, _)| *name != "#");
    samples.map(|(name, hex)| (name, bytes(hex)))
}

/// The content of the samples.
fn content() -> String {
    (0..20).fold("x,y,z\n".to_owned(), |mut text, k| {
        writeln!(text, "{k},{},2", k * k % 7).expect("memory");
        text
    })
}

fn unpacked(data: &[u8]) -> io::Result<Vec<u8>> {
    let packing = Packing::of(data).expect("compressed");
    let mut found = Vec::new();
    packing.reader(Cursor::new(data.to_vec()), &Arc::default()).read_to_end(&mut found)?;
    Ok(found)
}

#[test]
fn data_of_other_programs_are_decompressed() {
    let mut count = 0;
    for (name, data) in samples() {
        assert_eq!(Packing::of(&data), Some(if name.starts_with("xz") { Packing::Xz } else { Packing::Zstandard }));
        let found = unpacked(&data).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(String::from_utf8_lossy(&found), content(), "{name}");
        count += 1;
    }
    assert_eq!(count, 11);
}

#[test]
fn other_content_than_the_checksum_says_is_refused() {
    let mut refused = 0;
    for (name, data) in samples().filter(|(name, _)| !["xz-none", "zst-plain"].contains(name)) {
        for bit in 0..8 * data.len() {
            let mut damaged = data.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            // Padding, skipped frames and the headers of frames have no checksum.
            match Packing::of(&damaged).map(|_| unpacked(&damaged)) {
                Some(Ok(found)) => assert!(content().into_bytes() == found || name == "zst-many", "{name} {bit}"),
                _ => refused += 1,
            }
        }
    }
    assert!(refused > 8000, "{refused}");
    // A frame without a checksum has the length of its content.
    let (_, mut plain) = samples().find(|(name, _)| *name == "zst-plain").expect("a frame");
    plain[5] ^= 1;
    let error = unpacked(&plain).expect_err("another length").to_string();
    assert!(error.contains("the length of the content differs"), "{error}");
}

#[test]
fn errors_say_which_program_tests_the_file() {
    for (name, data) in samples() {
        for end in 12..data.len() {
            // Of several parts, some end where one does.
            let Err(error) = unpacked(&data[..end]) else { continue };
            let program = if name.starts_with("xz") { "`xz -t`" } else { "`zstd -t`" };
            let text = error.to_string();
            // Padding between streams that is cut is damaged padding.
            let is_cut = text.contains("data end too early") || name == "xz-many" && text.contains("data are damaged");
            assert!(text.contains(program) && is_cut, "{name} {end}: {text}");
        }
        let mut behind = data;
        behind.extend_from_slice(b"behind it");
        assert!(unpacked(&behind).is_err(), "{name}");
    }
}

#[test]
fn windows_are_limited() {
    for (data, program) in [
        // 2^28 bytes, without and with a length; 192 MiB.
        ("28b52ffd0090190000616263", "zstd"),
        ("28b52ffda00000001003000061626300", "zstd"),
        (
            "fd377a585a000000ff12d941020021011f000000fe60edde01000261626300000001130303a560d806729e7a010000000000595a",
            "xz",
        ),
    ] {
        let text = unpacked(&bytes(data)).expect_err(data).to_string();
        assert!(text.contains("more than 128 MiB") && text.contains(&format!("`{program} -d`")), "{text}");
    }
    // A dictionary that the file does not have.
    let text = unpacked(&bytes("28b52ffd23c018341e884500000001008582940002")).expect_err("a dictionary").to_string();
    assert!(text.contains("ictionary"), "{text}");
}
