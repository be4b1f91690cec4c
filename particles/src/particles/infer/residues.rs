//! Residues by name and their kind of molecule, with the names of the Protein Data Bank, CHARMM, AMBER, GROMACS and
//! GROMOS. Sources: the wwPDB chemical component dictionary; CHARMM36 top_all36_prot.rtf, _na, _lipid and
//! toppar_water_ions.str; AMBER leaprc.protein.ff19SB and lipid21; GROMACS residuetypes.dat.

/// The kind of molecule of a residue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ResidueClass {
    Protein,
    Nucleic,
    Water,
    /// Lipids, sugars and terminal caps of proteins.
    Other,
    /// A single bead of a coarse-grained solvent (Martini).
    Bead,
}

/// The class of a residue's name in capitals; `None` for ligands, ions and all names that are not listed.
pub(crate) fn class(name: &[u8]) -> Option<ResidueClass> {
    let listed = match name {
        b"WAT" | b"HOH" | b"H2O" | b"DOD" | b"D2O" | b"SOL" | b"TIP" | b"TIP2" | b"TIP3" | b"TIP4" | b"TIP5"
        | b"TIP3P" | b"TIP4P" | b"TIP5P" | b"TP3" | b"TP4" | b"TP5" | b"TP3M" | b"TP4M" | b"TP5M" | b"T3P" | b"T4P"
        | b"T4E" | b"T5P" | b"SPC" | b"SPCE" | b"OPC" | b"OPC3" | b"FB3" | b"FB4" | b"PL3" | b"POL3" | b"DC4"
        | b"SPF" | b"SPG" | b"SWM" | b"SWM4" | b"SWM6" | b"SW4" | b"SW6" | b"OH2" | b"WTR" | b"MTO" => {
            Some(ResidueClass::Water)
        }
        b"W" | b"WF" | b"WN" | b"PW" | b"TW" => Some(ResidueClass::Bead),
        b"POPC" | b"POPE" | b"POPG" | b"POPS" | b"POPA" | b"POPI" | b"POP" | b"DPPC" | b"DPPE" | b"DPPG" | b"DPPS"
        | b"DPPA" | b"DMPC" | b"DMPE" | b"DMPG" | b"DMPS" | b"DMPA" | b"DOPC" | b"DOPE" | b"DOPG" | b"DOPS"
        | b"DOPA" | b"DSPC" | b"DSPE" | b"DSPG" | b"DLPC" | b"DLPE" | b"DLPG" | b"DLPS" | b"DLIPC" | b"DAPC"
        | b"SOPC" | b"SOPE" | b"SAPC" | b"SAPE" | b"SAPI" | b"SDPC" | b"SDPE" | b"PLPC" | b"PLPE" | b"PYPC"
        | b"PYPE" | b"PYPG" | b"PMPE" | b"PMPG" | b"PVPE" | b"PVPG" | b"PSM" | b"SSM" | b"CER" | b"CHL1" | b"CHL"
        | b"CHOL" | b"CLR" | b"ERG" | b"SITO" | b"STIG" | b"CAMP" | b"TOCL1" | b"TOCL2" | b"TLCL1" | b"TLCL2"
        | b"TMCL2" | b"LPPC" | b"LPC" | b"SDS" | b"DPC" | b"DDM" | b"LDA" | b"OLA" | b"PLM" | b"PAL" | b"STE"
        | b"MYR" | b"OLE" | b"LAL" | b"DHA" => Some(ResidueClass::Other),
        b"NAG" | b"NDG" | b"BMA" | b"MAN" | b"BGC" | b"GLC" | b"GAL" | b"GLA" | b"FUC" | b"FUL" | b"XYP" | b"XYS"
        | b"SIA" | b"SLB" | b"RAM" | b"SUC" | b"BGLC" | b"AGLC" | b"BMAN" | b"AMAN" | b"BGAL" | b"AGAL" | b"BGLCNA"
        | b"AGLCNA" | b"BGALNA" | b"AGALNA" | b"AFUC" | b"BFUC" | b"BXYL" | b"AXYL" | b"ANE5" | b"ANE5AC"
        | b"BNE5AC" => Some(ResidueClass::Other),
        b"ACEX" | b"NMA" | b"NH2" | b"NHE" | b"FOR" | b"NAC" | b"CT3" => Some(ResidueClass::Other),
        _ if is_amino_acid(name) => Some(ResidueClass::Protein),
        _ if is_nucleotide(name) => Some(ResidueClass::Nucleic),
        _ => None,
    };
    // AMBER marks the residue at either end of a chain: NALA, CALA.
    listed.or_else(|| match name {
        [b'N' | b'C', rest @ ..] if rest.len() == 3 && is_amino_acid(rest) => Some(ResidueClass::Protein),
        _ => None,
    })
}

fn is_amino_acid(name: &[u8]) -> bool {
    matches!(
        name,
        b"ALA" | b"ARG" | b"ASN" | b"ASP" | b"ASX" | b"CYS" | b"GLN" | b"GLU" | b"GLX" | b"GLY" | b"HIS" | b"ILE"
            | b"LEU" | b"LYS" | b"MET" | b"PHE" | b"PRO" | b"SER" | b"THR" | b"TRP" | b"TYR" | b"VAL" | b"SEC" | b"PYL"
            | b"UNK" | b"MSE" | b"HYP" | b"MLY" | b"MLZ" | b"M3L" | b"SEP" | b"TPO" | b"PTR" | b"S1P" | b"T1P" | b"Y1P"
            | b"SP1" | b"SP2" | b"THP1" | b"THP2" | b"TP1" | b"TP2" | b"KCX" | b"LLP" | b"CSO" | b"CSD" | b"CME" | b"CMT"
            | b"OCS" | b"CSS" | b"CSX" | b"PCA" | b"ORN" | b"NLE" | b"NVA" | b"AIB" | b"ABA" | b"DAL" | b"DAR" | b"DSG"
            | b"DAS" | b"DCY" | b"DGN" | b"DGL" | b"DHI" | b"DIL" | b"DLE" | b"DLY" | b"MED" | b"DPN" | b"DPR" | b"DSN"
            | b"DTH" | b"DTR" | b"DTY" | b"DVA"
            // Protonation states.
            | b"HSD" | b"HSE" | b"HSP" | b"HID" | b"HIE" | b"HIP" | b"HISA" | b"HISB" | b"HISD" | b"HISE" | b"HISH"
            | b"HISP" | b"HIS1" | b"HIS2" | b"HISN" | b"CYX" | b"CYM" | b"CYN" | b"CYSH" | b"CYS1" | b"CYS2" | b"CYS3"
            | b"ASH" | b"ASPH" | b"ASPP" | b"AS4" | b"GLH" | b"GLUH" | b"GLUP" | b"GL4" | b"LYN" | b"LYSH" | b"LSN"
            | b"LYP" | b"ARN" | b"ARGN" | b"AR0" | b"TYM" | b"TYRU" | b"QLN"
            // Terminal caps that MDAnalysis counts as protein.
            | b"ACE" | b"NME"
    )
}

/// Bases by one letter, as deoxynucleotides, as named by CHARMM and AMBER, at either end of a chain (`DA5`, `RU3`,
/// `AN`).
fn is_nucleotide(name: &[u8]) -> bool {
    let base = |name: &[u8]| matches!(name, [b'A' | b'C' | b'G' | b'T' | b'U' | b'I']);
    let with_sugar = |name: &[u8]| match name {
        [b'D' | b'R', rest @ ..] => base(rest),
        _ => base(name),
    };
    match name {
        b"ADE" | b"CYT" | b"GUA" | b"THY" | b"URA" | b"PSU" | b"H2U" | b"5MU" | b"5MC" | b"1MA" | b"2MG" | b"7MG"
        | b"M2G" | b"OMC" | b"OMG" | b"YYG" => true,
        [rest @ .., b'3' | b'5' | b'N'] if !rest.is_empty() => with_sugar(rest),
        _ => with_sugar(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residues_are_known_by_the_names_of_all_programs() {
        for (class_of, names) in [
            (Some(ResidueClass::Protein), "ALA HSD HIE HISH CYX ASH GLH LYN MSE NALA CGLY ACE NME"),
            (Some(ResidueClass::Nucleic), "A DA RU DG5 U3 AN ADE"),
            (Some(ResidueClass::Water), "HOH SOL TIP3 SWM4"),
            (Some(ResidueClass::Other), "POPC CHL1 NAG FOR NH2"),
            (Some(ResidueClass::Bead), "W PW"),
            (None, "LIG HEM NA CL CAL CLA SOD POT ZN N 3 X MG NACE2"),
        ] {
            for name in names.split(' ') {
                assert_eq!(class(name.as_bytes()), class_of, "{name}");
            }
        }
    }
}
