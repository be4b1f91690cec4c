//! Radii and colours of the elements, as is customary in molecular graphics.

/// An element of the periodic table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Its symbol: `Fe`.
    pub symbol: &'static str,
    /// Van der Waals radius, ångström: Bondi, J. Phys. Chem. 68, 441 (1964), and for the main group elements missing
    /// there Mantina et al., J. Phys. Chem. A 113, 5806 (2009); for the others Alvarez, Dalton Trans. 42, 8617 (2013).
    /// `None` where no source gives one.
    pub vdw: Option<f64>,
    /// Covalent radius, ångström: Cordero et al., Dalton Trans. 2832 (2008), up to curium.
    pub covalent: Option<f64>,
    /// 8-bit sRGB, Jmol's colours (jmol.sourceforge.net/jscolors), up to meitnerium; then deep pink, Jmol's colour of
    /// unknown elements.
    pub color: u32,
}

/// The element of an atomic number; `None` for 0, which means unknown, and above 118.
#[must_use]
pub fn element(number: u8) -> Option<&'static Element> {
    ELEMENTS.get(usize::from(number).checked_sub(1)?)
}

/// The atomic number of a symbol in upper or lower case; `D` and `T` are hydrogen. 0 if it is not an element.
#[must_use]
pub fn atomic_number(symbol: &str) -> u8 {
    let place = |letter: u8| usize::from(letter.to_ascii_lowercase().wrapping_sub(b'a'));
    let number = match *symbol.as_bytes() {
        [b'D' | b'd' | b'T' | b't'] => Some(&1),
        [letter] => NUMBERS.get(place(letter)).map(|row| &row[ALONE]),
        [first, second] => NUMBERS.get(place(first)).and_then(|row| row[..ALONE].get(place(second))),
        _ => None,
    };
    number.copied().unwrap_or(0)
}

/// The column of one-letter symbols in [`NUMBERS`].
const ALONE: usize = 26;

/// Atomic numbers by the symbol's first and second letter; a table, because files contain millions of atoms.
static NUMBERS: [[u8; 27]; 26] = {
    let mut numbers = [[0; 27]; 26];
    let mut n = 0;
    while n < ELEMENTS.len() {
        let symbol = ELEMENTS[n].symbol.as_bytes();
        let second = if symbol.len() > 1 { (symbol[1] - b'a') as usize } else { ALONE };
        numbers[(symbol[0] - b'A') as usize][second] = n as u8 + 1;
        n += 1;
    }
    numbers
};

const fn row(symbol: &'static str, vdw: f64, covalent: f64, color: u32) -> Element {
    let vdw = if vdw > 0.0 { Some(vdw) } else { None };
    let covalent = if covalent > 0.0 { Some(covalent) } else { None };
    Element { symbol, vdw, covalent, color }
}

/// By atomic number, from 1: symbol, van der Waals radius, covalent radius (0 where there is none), colour.
#[rustfmt::skip]
const ELEMENTS: [Element; 118] = [
    row("H", 1.2, 0.31, 0xffffff),
    row("He", 1.4, 0.28, 0xd9ffff),
    row("Li", 1.82, 1.28, 0xcc80ff),
    row("Be", 1.53, 0.96, 0xc2ff00),
    row("B", 1.92, 0.84, 0xffb5b5),
    row("C", 1.7, 0.76, 0x909090),
    row("N", 1.55, 0.71, 0x3050f8),
    row("O", 1.52, 0.66, 0xff0d0d),
    row("F", 1.47, 0.57, 0x90e050),
    row("Ne", 1.54, 0.58, 0xb3e3f5),
    row("Na", 2.27, 1.66, 0xab5cf2),
    row("Mg", 1.73, 1.41, 0x8aff00),
    row("Al", 1.84, 1.21, 0xbfa6a6),
    row("Si", 2.1, 1.11, 0xf0c8a0),
    row("P", 1.8, 1.07, 0xff8000),
    row("S", 1.8, 1.05, 0xffff30),
    row("Cl", 1.75, 1.02, 0x1ff01f),
    row("Ar", 1.88, 1.06, 0x80d1e3),
    row("K", 2.75, 2.03, 0x8f40d4),
    row("Ca", 2.31, 1.76, 0x3dff00),
    row("Sc", 2.58, 1.7, 0xe6e6e6),
    row("Ti", 2.46, 1.6, 0xbfc2c7),
    row("V", 2.42, 1.53, 0xa6a6ab),
    row("Cr", 2.45, 1.39, 0x8a99c7),
    row("Mn", 2.45, 1.39, 0x9c7ac7),
    row("Fe", 2.44, 1.32, 0xe06633),
    row("Co", 2.4, 1.26, 0xf090a0),
    row("Ni", 1.63, 1.24, 0x50d050),
    row("Cu", 1.4, 1.32, 0xc88033),
    row("Zn", 1.39, 1.22, 0x7d80b0),
    row("Ga", 1.87, 1.22, 0xc28f8f),
    row("Ge", 2.11, 1.2, 0x668f8f),
    row("As", 1.85, 1.19, 0xbd80e3),
    row("Se", 1.9, 1.2, 0xffa100),
    row("Br", 1.85, 1.2, 0xa62929),
    row("Kr", 2.02, 1.16, 0x5cb8d1),
    row("Rb", 3.03, 2.2, 0x702eb0),
    row("Sr", 2.49, 1.95, 0x00ff00),
    row("Y", 2.75, 1.9, 0x94ffff),
    row("Zr", 2.52, 1.75, 0x94e0e0),
    row("Nb", 2.56, 1.64, 0x73c2c9),
    row("Mo", 2.45, 1.54, 0x54b5b5),
    row("Tc", 2.44, 1.47, 0x3b9e9e),
    row("Ru", 2.46, 1.46, 0x248f8f),
    row("Rh", 2.44, 1.42, 0x0a7d8c),
    row("Pd", 1.63, 1.39, 0x006985),
    row("Ag", 1.72, 1.45, 0xc0c0c0),
    row("Cd", 1.58, 1.44, 0xffd98f),
    row("In", 1.93, 1.42, 0xa67573),
    row("Sn", 2.17, 1.39, 0x668080),
    row("Sb", 2.06, 1.39, 0x9e63b5),
    row("Te", 2.06, 1.38, 0xd47a00),
    row("I", 1.98, 1.39, 0x940094),
    row("Xe", 2.16, 1.4, 0x429eb0),
    row("Cs", 3.43, 2.44, 0x57178f),
    row("Ba", 2.49, 2.15, 0x00c900),
    row("La", 2.98, 2.07, 0x70d4ff),
    row("Ce", 2.88, 2.04, 0xffffc7),
    row("Pr", 2.92, 2.03, 0xd9ffc7),
    row("Nd", 2.95, 2.01, 0xc7ffc7),
    row("Pm", 0.0, 1.99, 0xa3ffc7),
    row("Sm", 2.9, 1.98, 0x8fffc7),
    row("Eu", 2.87, 1.98, 0x61ffc7),
    row("Gd", 2.83, 1.96, 0x45ffc7),
    row("Tb", 2.79, 1.94, 0x30ffc7),
    row("Dy", 2.87, 1.92, 0x1fffc7),
    row("Ho", 2.81, 1.92, 0x00ff9c),
    row("Er", 2.83, 1.89, 0x00e675),
    row("Tm", 2.79, 1.9, 0x00d452),
    row("Yb", 2.8, 1.87, 0x00bf38),
    row("Lu", 2.74, 1.87, 0x00ab24),
    row("Hf", 2.63, 1.75, 0x4dc2ff),
    row("Ta", 2.53, 1.7, 0x4da6ff),
    row("W", 2.57, 1.62, 0x2194d6),
    row("Re", 2.49, 1.51, 0x267dab),
    row("Os", 2.48, 1.44, 0x266696),
    row("Ir", 2.41, 1.41, 0x175487),
    row("Pt", 1.75, 1.36, 0xd0d0e0),
    row("Au", 1.66, 1.36, 0xffd123),
    row("Hg", 1.55, 1.32, 0xb8b8d0),
    row("Tl", 1.96, 1.45, 0xa6544d),
    row("Pb", 2.02, 1.46, 0x575961),
    row("Bi", 2.07, 1.48, 0x9e4fb5),
    row("Po", 1.97, 1.4, 0xab5c00),
    row("At", 2.02, 1.5, 0x754f45),
    row("Rn", 2.2, 1.5, 0x428296),
    row("Fr", 3.48, 2.6, 0x420066),
    row("Ra", 2.83, 2.21, 0x007d00),
    row("Ac", 2.8, 2.15, 0x70abfa),
    row("Th", 2.93, 2.06, 0x00baff),
    row("Pa", 2.88, 2.0, 0x00a1ff),
    row("U", 1.86, 1.96, 0x008fff),
    row("Np", 2.82, 1.9, 0x0080ff),
    row("Pu", 2.81, 1.87, 0x006bff),
    row("Am", 2.83, 1.8, 0x545cf2),
    row("Cm", 3.05, 1.69, 0x785ce3),
    row("Bk", 3.4, 0.0, 0x8a4fe3),
    row("Cf", 3.05, 0.0, 0xa136d4),
    row("Es", 2.7, 0.0, 0xb31fd4),
    row("Fm", 0.0, 0.0, 0xb31fba),
    row("Md", 0.0, 0.0, 0xb30da6),
    row("No", 0.0, 0.0, 0xbd0d87),
    row("Lr", 0.0, 0.0, 0xc70066),
    row("Rf", 0.0, 0.0, 0xcc0059),
    row("Db", 0.0, 0.0, 0xd1004f),
    row("Sg", 0.0, 0.0, 0xd90045),
    row("Bh", 0.0, 0.0, 0xe00038),
    row("Hs", 0.0, 0.0, 0xe6002e),
    row("Mt", 0.0, 0.0, 0xeb0026),
    row("Ds", 0.0, 0.0, 0xff1493),
    row("Rg", 0.0, 0.0, 0xff1493),
    row("Cn", 0.0, 0.0, 0xff1493),
    row("Nh", 0.0, 0.0, 0xff1493),
    row("Fl", 0.0, 0.0, 0xff1493),
    row("Mc", 0.0, 0.0, 0xff1493),
    row("Lv", 0.0, 0.0, 0xff1493),
    row("Ts", 0.0, 0.0, 0xff1493),
    row("Og", 0.0, 0.0, 0xff1493),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// A few numbers of each source, read from the papers, and the ends of the table.
    #[test]
    fn elements_are_found_and_look_as_cited() {
        let of = |symbol: &str| element(atomic_number(symbol)).expect("an element");
        assert_eq!((of("C").vdw, of("c").covalent, of("C").color), (Some(1.7), Some(0.76), 0x909090));
        assert_eq!((of("FE").symbol, of("Fe").covalent, atomic_number("fe")), ("Fe", Some(1.32), 26));
        assert_eq!((of("D").symbol, of("Al").vdw, of("O").vdw), ("H", Some(1.84), Some(1.52)));
        assert_eq!((of("Og").symbol, of("Og").vdw, atomic_number("Og")), ("Og", None, 118));
        assert_eq!((atomic_number("X"), atomic_number(""), element(0), element(119)), (0, 0, None, None));
        for number in 1..=118 {
            assert_eq!(atomic_number(element(number).expect("all are there").symbol), number);
        }
    }
}
