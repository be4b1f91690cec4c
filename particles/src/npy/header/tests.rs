use super::*;

fn file(version: u8, text: &str) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((text.len() as u16).to_le_bytes()),
        _ => bytes.extend((text.len() as u32).to_le_bytes()),
    }
    bytes.extend(text.as_bytes());
    bytes
}

fn read(text: &str) -> Result<Header, Fault> {
    Header::read(&mut &file(1, text)[..])
}

fn plain(name: &str) -> DType {
    DType::Plain(name.into())
}

#[test]
fn headers_as_numpy_writes_them() {
    // The texts were written by NumPy 2.2, by Python 2's (L), and by numpy.save of a record.
    let cases = [
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }          \n", plain("<f8"), false, vec![3, 4]),
        ("{'descr': '>f4', 'fortran_order': True, 'shape': (7,), }\n", plain(">f4"), true, vec![7]),
        ("{\"descr\": \"|u1\", \"fortran_order\": False, \"shape\": (2L, 3L)}", plain("|u1"), false, vec![2, 3]),
        ("{'descr': '<i4', 'fortran_order': False, 'shape': (), }", plain("<i4"), false, vec![]),
    ];
    for (text, dtype, fortran, shape) in cases {
        for version in [1, 2, 3] {
            let bytes = [file(version, text), b"data".to_vec()].concat();
            let mut rest = &bytes[..];
            let header = Header::read(&mut rest).expect(text);
            assert_eq!(header, Header { dtype: dtype.clone(), fortran, shape: shape.clone() });
            assert_eq!(rest, b"data", "the reader is at the first value");
        }
    }
    let text = "{'descr': [('x', '<f8'), (('title', 'pos'), '<f4', (3,)), ('m', '<i2', (2, 3)), ('s', '<U5'), ('when', \
                '<M8[ns]'), ('inner', [('a', '|b1')]), ('', '|V3')], 'fortran_order': False, 'shape': (9,), }";
    let header = read(text).expect("a record");
    let DType::Record(fields) = &header.dtype else { panic!("{header:?}") };
    let names: Vec<_> = fields.iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["x", "pos", "m", "s", "when", "inner", ""]);
    let sizes: Vec<_> = fields.iter().filter_map(|field| field.dtype.bytes()).collect();
    assert_eq!(sizes, [8, 12, 12, 20, 8, 1, 3]);
    assert_eq!(fields[2].dtype, DType::Array(2, Box::new(DType::Array(3, Box::new(plain("<i2"))))));
    assert_eq!(header.dtype.bytes(), Some(64));
    assert_eq!(plain("|O").bytes(), None, "objects have no size");
}

#[test]
fn other_texts_are_refused() {
    let good = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }";
    assert!(read(good).is_ok());
    for (from, to) in [
        ("'<f8'", "7"),
        ("False", "0"),
        ("False", "None"),
        ("(3, 4)", "3"),
        ("(3, 4)", "(3, -4)"),
        ("(3, 4)", "(3, 4.0)"),
        ("(3, 4)", "(3 4)"),
        ("(3, 4)", "(3,, 4)"),
        ("(3, 4)", "(,)"),
        ("(3, 4)", "(18446744073709551616,)"),
        ("(3, 4), }", "(3, 4), } {}"),
        ("'shape'", "'Shape'"),
        ("'descr'", "descr"),
        ("'<f8'", "'<f8"),
        ("'<f8'", "[('x',)]"),
        ("'<f8'", "[('x', '<f8', 'y')]"),
        ("'<f8'", "'\\x3cf8'"),
        ("}", ""),
    ] {
        let text = good.replacen(from, to, 1);
        assert!(matches!(read(&text), Err(Fault::Malformed(_))), "{text}");
    }
    let deep = good.replacen("'<f8'", &"[".repeat(5000), 1);
    assert!(matches!(read(&deep), Err(Fault::Malformed(_))), "brackets end the parser, not the stack");
    assert!(matches!(Header::read(&mut &file(4, good)[..]), Err(Fault::Malformed(_))));
    assert!(matches!(Header::read(&mut &file(2, &" ".repeat(LONGEST + 1))[..]), Err(Fault::Long(10_001))));
    assert!(matches!(Header::read(&mut &b"\x93NUMPZ\x01\x00"[..]), Err(Fault::Magic)));
    for end in 0..file(1, good).len() {
        assert!(matches!(Header::read(&mut &file(1, good)[..end]), Err(Fault::Cut)), "{end}");
    }
    for shape in ["(4294967296, 4294967296)", "(4294967296, 0, 4294967296)", "(2305843009213693952,)"] {
        assert!(matches!(read(&good.replacen("(3, 4)", shape, 1)), Err(Fault::Malformed(_))), "{shape}");
    }
    let empty = read(&good.replacen("(3, 4)", "(0, 4)", 1)).expect("an array without rows");
    assert_eq!(empty.data_bytes(), Some(0));
}

/// The bytes that `numpy.lib.format.write_array_header_1_0` writes for these arrays, but for a blank behind the last comma.
#[test]
fn a_header_is_aligned_and_reads_back() {
    let bytes = Header::bytes("<f4", &[480, 640, 3]);
    let text = "{'descr': '<f4', 'fortran_order': False, 'shape': (480, 640, 3, ), }";
    assert_eq!(bytes, [&b"\x93NUMPY\x01\x00\x76\x00"[..], text.as_bytes(), &[b' '; 49], b"\n"].concat());
    for shape in [&[1][..], &[], &[1 << 40, 2]] {
        let bytes = Header::bytes("|u1", shape);
        assert_eq!(bytes.len() % 64, 0);
        let header = Header::read(&mut &bytes[..]).expect("a header");
        assert_eq!(header, Header { dtype: plain("|u1"), fortran: false, shape: shape.to_vec() });
    }
}
