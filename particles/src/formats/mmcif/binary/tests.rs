use super::*;
use crate::formats::mmcif::Mmcif;
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::request::Request;

fn map(entries: Vec<(&str, Value)>) -> Value {
    Value::Map(entries.into_iter().map(|(key, value)| (key.into(), value)).collect())
}

fn bytes_of(numbers: &[i8]) -> Value {
    Value::Binary(numbers.iter().map(|x| *x as u8).collect())
}

fn byte_array(kind: i64) -> Value {
    map(vec![("kind", "ByteArray".into()), ("type", kind.into())])
}

/// Bytes of numbers with these encodings before the encoding of the bytes.
fn encoded(numbers: &[i8], before: Vec<Value>) -> Value {
    let encoding = before.into_iter().chain([byte_array(1)]).collect();
    map(vec![("data", bytes_of(numbers)), ("encoding", Value::Array(encoding))])
}

fn encoding(kind: &str, mut rest: Vec<(&str, Value)>) -> Value {
    rest.insert(0, ("kind", kind.into()));
    map(rest)
}

/// Words of a column, until it ends.
fn words(data: Value, mask: Value) -> Result<Vec<String>, String> {
    let mut column = Column::new("a".to_owned(), map(vec![("data", data), ("mask", mask)]), 16)?;
    let mut found = Vec::new();
    loop {
        let mut word = Vec::new();
        match column.next(&mut word) {
            Ok(()) => found.push(String::from_utf8(word).expect("text")),
            Err(problem) if problem == "there is no value" => return Ok(found),
            Err(problem) => return Err(problem),
        }
    }
}

/// `{kind: StringArray}` of these texts.
fn strings(data: &str, offsets: &[i8], indices: &[i8]) -> Value {
    let plain = || Value::Array(vec![byte_array(1)]);
    let array = encoding(
        "StringArray",
        vec![
            ("stringData", data.into()),
            ("offsets", bytes_of(offsets)),
            ("offsetEncoding", plain()),
            ("dataEncoding", plain()),
        ],
    );
    map(vec![("data", bytes_of(indices)), ("encoding", Value::Array(vec![array]))])
}

/// The examples of the specification.
#[test]
fn encodings_are_undone() {
    let packing = |count: i64, is_unsigned: bool| {
        encoding("IntegerPacking", vec![("byteCount", count.into()), ("isUnsigned", is_unsigned.into())])
    };
    let interval =
        || encoding("IntervalQuantization", vec![("min", 1.into()), ("max", 2.into()), ("numSteps", 3.into())]);
    let delta = || encoding("Delta", vec![("origin", 1000.into())]);
    let fixed = || encoding("FixedPoint", vec![("factor", 100.into())]);
    for (numbers, before, expected) in [
        (&[120, 127, 12][..], vec![fixed()], &["1.2", "1.27", "0.12"][..]),
        (&[0, 0, 1, 2, 2, 1], vec![interval()], &["1", "1", "1.5", "2", "2", "1.5"]),
        (&[1, 3, 2, 1, 3, 2], vec![encoding("RunLength", vec![])], &["1", "1", "1", "2", "3", "3"]),
        (&[5, 0, 6, -1, 7, 1], vec![encoding("RunLength", vec![])], &["7"]),
        (&[0, 3, 2, 1], vec![delta()], &["1000", "1003", "1005", "1006"]),
        (&[1, 2, -3, 127, 1], vec![packing(1, false)], &["1", "2", "-3", "128"]),
        (&[127, 0, -128, -128, 0, 127, 127, 3], vec![packing(1, false)], &["127", "-256", "257"]),
        (&[100, 2, 1, 1], vec![fixed(), delta(), encoding("RunLength", vec![])], &["11", "12", "12.01"]),
    ] {
        assert_eq!(words(encoded(numbers, before), Value::Nil).expect("values"), expected);
    }
    assert_eq!(words(strings("aAB", &[0, 1, 3], &[0, 1, 0, -1]), Value::Nil).expect("texts"), ["a", "AB", "a", ""]);
    let masked = words(strings("aAB", &[0, 1, 3], &[0, 1, 0]), encoded(&[0, 1, 2], vec![])).expect("texts");
    assert_eq!(masked, ["a", "", ""]);
}

/// The types of the bytes: the same two numbers.
#[test]
fn numbers_have_their_type() {
    for (kind, bytes) in [
        (1, vec![1, 0xfe]),
        (2, vec![1, 0, 0xfe, 0xff]),
        (3, vec![1, 0, 0, 0, 0xfe, 0xff, 0xff, 0xff]),
        (32, [1f32, -2.0].map(f32::to_le_bytes).concat()),
        (33, [1f64, -2.0].map(f64::to_le_bytes).concat()),
    ] {
        let data = map(vec![("data", Value::Binary(bytes)), ("encoding", Value::Array(vec![byte_array(kind)]))]);
        assert_eq!(words(data, Value::Nil).expect("numbers"), ["1", "-2"], "{kind}");
    }
    for (kind, bytes, expected) in [(4, vec![255], "255"), (5, vec![255; 2], "65535"), (6, vec![255; 4], "4294967295")]
    {
        let data = map(vec![("data", Value::Binary(bytes)), ("encoding", Value::Array(vec![byte_array(kind)]))]);
        assert_eq!(words(data, Value::Nil).expect("numbers"), [expected], "{kind}");
    }
}

#[test]
fn problems_of_columns_are_named() {
    let one = |kind: &str, rest| encoded(&[1], vec![encoding(kind, rest)]);
    for (data, problem) in [
        (one("Zip", vec![]), "there is no encoding `Zip`"),
        (one("FixedPoint", vec![]), "factor is not a finite number"),
        (one("Delta", vec![("origin", 0.5.into())]), "origin is not a whole number"),
        (one("IntegerPacking", vec![("byteCount", 4.into())]), "byteCount is 4, not 1 or 2"),
        (map(vec![("encoding", Value::Array(vec![byte_array(1)]))]), "data has no bytes"),
        (map(vec![("data", bytes_of(&[1]))]), "there is no array of encodings"),
        (map(vec![("data", bytes_of(&[1])), ("encoding", Value::Array(vec![]))]), "there is no encoding"),
        (map(vec![("data", bytes_of(&[1])), ("encoding", Value::Array(vec![byte_array(7)]))]), "there is no type 7"),
        (strings("aAB", &[0, 1, 9], &[1]), "its text is not in stringData"),
        (strings("aAB", &[0, 1, 3], &[2]), "there is no text of its index"),
        (strings("a", &[0, 0, 0, 1], &[0]), "stringData has fewer bytes than texts"),
        (
            encoded(
                &[1],
                vec![encoding("Delta", vec![("origin", 0.into())]), encoding("FixedPoint", vec![("factor", 1.into())])],
            ),
            "an encoding has other values than whole numbers",
        ),
    ] {
        assert_eq!(words(data, Value::Nil).expect_err(problem).get(..problem.len()), Some(problem));
    }
    assert_eq!(words(strings("a", &[0, 1], &[0, 0]), encoded(&[0], vec![])), Err("the mask has no value".into()));
}

/// A file of three atoms, one of them without coordinates.
fn file(rows: i64) -> Value {
    let column =
        |name: &str, data: Value, mask: Value| map(vec![("name", name.into()), ("data", data), ("mask", mask)]);
    let fixed = || encoding("FixedPoint", vec![("factor", 4.into())]);
    let mask = || encoded(&[0, 2, 0], vec![]);
    let axis = |name: &str, numbers: &[i8]| column(name, encoded(numbers, vec![fixed()]), mask());
    let atoms = vec![
        column("type_symbol", strings("OFe", &[0, 1, 3], &[0, 0, 1]), Value::Nil),
        axis("Cartn_x", &[1, 0, 4]),
        axis("Cartn_y", &[2, 0, 5]),
        axis("Cartn_z", &[3, 0, 6]),
        column("B_iso_or_equiv", encoded(&[9, 9, 8], vec![]), Value::Nil),
    ];
    let length = |name: &str| column(name, encoded(&[10], vec![]), Value::Nil);
    let cell = vec![length("length_a"), length("length_b"), length("length_c")];
    let category = |name: &str, rows: i64, columns| {
        map(vec![("name", name.into()), ("rowCount", rows.into()), ("columns", Value::Array(columns))])
    };
    let categories = vec![
        category("_unused", 1 << 40, vec![column("a", Value::Nil, Value::Nil)]),
        category("_atom_site", rows, atoms),
        category("cell", 1, cell),
    ];
    let block = map(vec![("header", "1ABC".into()), ("categories", Value::Array(categories))]);
    map(vec![("encoder", "by hand".into()), ("version", "0.3.0".into()), ("dataBlocks", Value::Array(vec![block]))])
}

fn written(file: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    rmpv::encode::write_value(&mut bytes, file).expect("memory");
    bytes
}

fn read(bytes: &[u8]) -> Result<Particles> {
    let mut frames = Mmcif::new(Source::of_bytes(bytes), Request::of(&["bfactor"]));
    frames.next().map(|frame| frame.expect("a frame"))
}

#[test]
fn atoms_and_the_cell_are_read_as_those_of_text() {
    let found = read(&written(&file(3))).expect("atoms");
    assert_eq!(found.positions, [[0.25, 0.5, 0.75], [1.0, 1.25, 1.5]]);
    assert_eq!((&found.elements[..], &found.columns[0].values[..]), (&[8, 26][..], &[9.0, 8.0][..]));
    assert_eq!(found.cell.expect("a cell").edges[0], [10.0, 0.0, 0.0]);
}

#[test]
fn damaged_files_are_refused_by_the_place() {
    let whole = written(&file(3));
    for (bytes, expected) in [
        (whole[..whole.len() - 1].to_vec(), "MessagePack: the file ends within it"),
        (written(&file(4)), "_atom_site.type_symbol: row 4 of 4: there is no value"),
        (written(&file(1 << 40)), "_atom_site: 1099511627776 rows of 5 columns in a file of"),
        (vec![0x80], "dataBlocks: there is no array dataBlocks"),
        ([vec![0x81, 0xa1, b'a'], vec![0x91; 200]].concat(), "MessagePack: more than 64 levels"),
        // An array of 2^32 - 1 numbers; one follows.
        (vec![0x81, 0xa1, b'a', 0xdd, 0xff, 0xff, 0xff, 0xff, 1], "MessagePack: the file ends within it"),
        (written(&map(vec![("dataBlocks", Value::Array(vec![]))])), "the file has no atoms"),
        (
            written(&map(vec![("dataBlocks", Value::Array(vec![Value::Nil]))])),
            "dataBlocks: there is no array categories",
        ),
    ] {
        let error = read(&bytes).map(drop).expect_err(expected).to_string();
        assert!(error.starts_with("text: ") && error.contains(expected), "{expected}: {error}");
    }
}

/// A file of these rows of atoms, whose x has these data and mask; other columns may follow.
fn atoms(rows: u64, symbol: Value, [x, mask]: [Value; 2], more: Vec<Value>) -> Vec<u8> {
    let zeros = || {
        let numbers: Vec<u8> = [0, rows as i32].map(i32::to_le_bytes).concat();
        let encoding = Value::Array(vec![encoding("RunLength", vec![]), byte_array(3)]);
        map(vec![("data", Value::Binary(numbers)), ("encoding", encoding)])
    };
    let column =
        |name: &str, data: Value, mask: Value| map(vec![("name", name.into()), ("data", data), ("mask", mask)]);
    let mut columns = vec![
        column("type_symbol", symbol, Value::Nil),
        column("Cartn_x", x, mask),
        column("Cartn_y", zeros(), Value::Nil),
        column("Cartn_z", zeros(), Value::Nil),
    ];
    columns.extend(more.into_iter().map(|data| column("other", data, Value::Nil)));
    let category =
        map(vec![("name", "_atom_site".into()), ("rowCount", rows.into()), ("columns", Value::Array(columns))]);
    let block = map(vec![("categories", Value::Array(vec![category]))]);
    written(&map(vec![("dataBlocks", Value::Array(vec![block]))]))
}

/// Neither the stack nor the time grow beyond what the file has bytes for.
#[test]
fn few_bytes_do_not_stand_for_a_deep_stack_or_a_long_time() {
    let delta = |n: usize| vec![encoding("Delta", vec![("origin", 0.into())]); n];
    let symbol = || strings("C", &[0, 1], &[0]);
    let plain = || [encoded(&[1], vec![]), Value::Nil];
    // A chain of 15 is read, and each of them alone would take the stack of another.
    assert_eq!(
        read(&atoms(1, symbol(), [encoded(&[1], delta(15)), Value::Nil], vec![])).expect("few").positions[0][0],
        1.0
    );
    let deep_text = || {
        let array = encoding(
            "StringArray",
            vec![
                ("stringData", "C".into()),
                ("offsets", bytes_of(&[0, 1])),
                ("offsetEncoding", Value::Array([delta(60_000), vec![byte_array(1)]].concat())),
                ("dataEncoding", Value::Array(vec![byte_array(1)])),
            ],
        );
        map(vec![("data", bytes_of(&[0])), ("encoding", Value::Array(vec![array]))])
    };
    let runs = |levels: usize, count: i32| {
        let bytes = [0, count].map(i32::to_le_bytes).concat().repeat(4);
        let encodings = vec![encoding("RunLength", vec![]); levels].into_iter().chain([byte_array(3)]).collect();
        map(vec![("data", Value::Binary(bytes)), ("encoding", Value::Array(encodings))])
    };
    let packed = || {
        let bytes = [127, i32::MAX].map(i32::to_le_bytes).concat();
        let packing = encoding("IntegerPacking", vec![("byteCount", 1.into()), ("isUnsigned", false.into())]);
        let encodings = vec![packing, encoding("RunLength", vec![]), byte_array(3)];
        map(vec![("data", Value::Binary(bytes)), ("encoding", Value::Array(encodings))])
    };
    let long = "C".repeat(100_000);
    let many = || {
        let offsets = [0, 100_000].map(i32::to_le_bytes).concat();
        let array = encoding(
            "StringArray",
            vec![
                ("stringData", long[..].into()),
                ("offsets", Value::Binary(offsets)),
                ("offsetEncoding", Value::Array(vec![byte_array(3)])),
                ("dataEncoding", Value::Array(vec![encoding("RunLength", vec![]), byte_array(3)])),
            ],
        );
        let indices = [0, 30_000].map(i32::to_le_bytes).concat();
        map(vec![("data", Value::Binary(indices)), ("encoding", Value::Array(vec![array]))])
    };
    for (bytes, expected) in [
        (atoms(1, symbol(), [encoded(&[1], delta(60_000)), Value::Nil], vec![]), "_atom_site.Cartn_x: 60001 encodings"),
        (atoms(1, symbol(), [encoded(&[1], vec![]), encoded(&[0], delta(60_000))], vec![]), "Cartn_x: 60001 encodings"),
        (atoms(1, deep_text(), plain(), vec![]), "type_symbol: 60001 encodings are more than 16"),
        (atoms(1, symbol(), [runs(3, i32::MAX), Value::Nil], vec![]), "Cartn_x: row 1 of 1: there is no value"),
        (atoms(1, symbol(), [packed(), Value::Nil], vec![]), "Cartn_x: row 1 of 1: there is no value"),
        (atoms(30_000, many(), [runs(1, 7500), Value::Nil], vec![]), "have more than 64 times the"),
        (
            atoms(40_000, runs(1, 10_000), [runs(1, 10_000), Value::Nil], vec![runs(1, 10_000); 1000]),
            "_atom_site: 40000 rows of 1004 columns in a file of",
        ),
    ] {
        let error = read(&bytes).map(drop).expect_err(expected).to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
