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
        assert!(text.contains("more than 128 MiB") && text.contains(&format!("`{program} -d")), "{text}");
        // The command of the message decompresses them, where it is installed and the data are whole.
        let command = text.split('`').nth(1).expect("a command");
        let mut words = command.split_whitespace();
        let whole = ["zstd", "--long=28", "-c"].map(str::to_owned);
        let source: Vec<u8> = match program {
            "zstd" => run(&whole[0], &whole[1..], b"x,y,z\n").unwrap_or_default(),
            _ => bytes(data),
        };
        let options: Vec<String> = words.by_ref().skip(1).map(str::to_owned).chain(["-c".to_owned()]).collect();
        if let (false, Some(content)) = (source.is_empty(), run(program, &options, &source)) {
            assert!(!content.is_empty(), "{command}");
        }
    }
    // A dictionary that the file does not have.
    let text = unpacked(&bytes("28b52ffd23c018341e884500000001008582940002")).expect_err("a dictionary").to_string();
    assert!(text.contains("ictionary"), "{text}");
}

/// The standard output of a program that is given these bytes; `None` where it is not installed.
fn run(program: &str, options: &[String], input: &[u8]) -> Option<Vec<u8>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("data");
    std::fs::write(&path, input).expect("a file");
    // A pipe, so that the size of the content is not known.
    let script = format!("cat '{}' | {program} {}", path.display(), options.join(" "));
    let output = std::process::Command::new("sh").args(["-c", &script]).output().ok()?;
    (output.status.code() != Some(127)).then_some(output.stdout)
}

/// Whether a program takes the data: it ends with 0.
fn is_taken(program: &str, data: &[u8]) -> Option<bool> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("data");
    std::fs::write(&path, data).expect("a file");
    let (input, nothing) = (std::fs::File::open(&path).expect("a file"), std::process::Stdio::null);
    let command =
        std::process::Command::new(program).arg("-t").stdin(input).stdout(nothing()).stderr(nothing()).status();
    command.ok().map(|status| status.success())
}

/// The data that are taken are those that the programs take, and so the advice of a message, to test the file with one of them, is true.
#[test]
fn what_is_taken_is_what_the_programs_take() {
    let programs = ["gzip", "bzip2", "xz", "zstd"];
    let mut draws = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |n: usize| {
        draws = draws.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (draws >> 33) as usize % n
    };
    let [mut taken, mut refused] = [0; 2];
    for program in programs {
        let packed = |content: &str, options: &[&str]| -> Option<Vec<u8>> {
            let mut child = std::process::Command::new(program)
                .args(options)
                .stdin(std::process::Stdio::piped())
                .stdout(std::process::Stdio::piped())
                .spawn()
                .ok()?;
            std::io::Write::write_all(&mut child.stdin.take()?, content.as_bytes()).ok()?;
            Some(child.wait_with_output().ok()?.stdout)
        };
        let Some(whole) = packed(&content(), &["-c"]) else {
            println!("{program} is not installed: not compared");
            continue;
        };
        let (one, none) = (packed("1", &["-9c"]).expect("data"), packed("", &["-c"]).expect("data"));
        let skipped = [0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 7, 7, 7];
        let zeros = |n: usize| vec![0; n];
        let mut files = vec![
            [&whole[..], &one].concat(),
            [&none[..], &whole, &none].concat(),
            [&one[..], &zeros(4), &one].concat(),
            [&one[..], &zeros(3), &one].concat(),
            [&skipped[..], &whole, &skipped].concat(),
            [&whole[..], &skipped[..9]].concat(),
            [&whole[..], b"behind it"].concat(),
            [&whole[..], b"B"].concat(),
            [&whole[..], b"BZ"].concat(),
            [&whole[..], b"BZh"].concat(),
            [&whole[..], b"BZh0"].concat(),
            [&whole[..], b"BZh9"].concat(),
            [&whole[..], b"\x1f"].concat(),
            [&whole[..], b"\x1f\x8b"].concat(),
            [&whole[..], b"\0\0x"].concat(),
            one.repeat(50),
            [&one[..], &none.repeat(300), &one].concat(),
            [&one[..], &none, &none[..none.len() - 1]].concat(),
        ];
        files.extend([1, 2, 3, 4, 5, 8, 511, 512, 100_000].map(|n| [&whole[..], &zeros(n)].concat()));
        for file in files.clone() {
            files.push(file[..file.len() - 1 - below(file.len() / 2)].to_vec());
        }
        for _ in 0..60 {
            let mut file = files[below(16)].clone();
            let at = if below(2) == 0 { below(file.len().min(24)) } else { below(file.len()) };
            file[at] ^= 1 << below(8);
            files.push(file);
        }
        for file in files {
            // Other beginnings are other compressions or none.
            if Packing::of(&file).is_none_or(|packing| packing.names()[1] != program) {
                continue;
            }
            let (ours, theirs) = (unpacked(&file), is_taken(program, &file).expect(program));
            let message = ours.as_ref().err().map(ToString::to_string).unwrap_or_default();
            // Data that only refer back too far are taken by the programs.
            if message.contains("refer back") {
                continue;
            }
            let hex: String = file.iter().take(200).map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(ours.is_ok(), theirs, "{program} {message} {} bytes {hex}", file.len());
            let count = if theirs { &mut taken } else { &mut refused };
            *count += 1;
        }
    }
    println!("{taken} data are taken, {refused} refused");
}
