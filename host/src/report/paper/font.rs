//! The font of figures, reduced to the characters of one figure: a TrueType file that SVG and PDF embed.
//!
//! Tables as in the OpenType specification. Hinting programs are left out: figures are drawn far above the size of a pixel.

use std::collections::BTreeMap;

/// DejaVu Sans, which is part of this program: the same on every machine.
pub const FAMILY: &str = "DejaVu Sans";

/// The table of that name; empty if the font has none.
fn table(font: &[u8], name: [u8; 4]) -> &[u8] {
    let record = |k: usize| font.get(12 + 16 * k..28 + 16 * k);
    let found = (0..usize::from(u16_at(font, 4))).filter_map(record).find(|record| record[..4] == name);
    let range = found.map(|record| (u32_at(record, 8) as usize, u32_at(record, 12) as usize));
    range.and_then(|(offset, length)| font.get(offset..offset + length)).unwrap_or_default()
}

/// Big-endian; 0 behind the end.
fn u16_at(bytes: &[u8], at: usize) -> u16 {
    bytes.get(at..at + 2).map_or(0, |b| u16::from_be_bytes([b[0], b[1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from(u16_at(bytes, at)) << 16 | u32::from(u16_at(bytes, at + 2))
}

/// Glyph of a character of the basic plane, by the font's table of format 4; 0 if it has none.
fn glyph(cmap: &[u8], character: char) -> u16 {
    let Ok(code) = u16::try_from(u32::from(character)) else { return 0 };
    let records = (0..usize::from(u16_at(cmap, 2))).map(|k| u32_at(cmap, 8 + 8 * k) as usize);
    let Some(t) = records.filter_map(|at| cmap.get(at..)).find(|t| u16_at(t, 0) == 4) else { return 0 };
    let double = usize::from(u16_at(t, 6));
    let Some(k) = (0..double / 2).find(|k| u16_at(t, 14 + 2 * k) >= code) else { return 0 };
    let (start, delta) = (u16_at(t, 16 + double + 2 * k), u16_at(t, 16 + 2 * double + 2 * k));
    let at = 16 + 3 * double + 2 * k;
    match (code >= start, usize::from(u16_at(t, at))) {
        (false, _) => 0,
        (true, 0) => code.wrapping_add(delta),
        (true, range) => match u16_at(t, at + range + 2 * usize::from(code - start)) {
            0 => 0,
            glyph => glyph.wrapping_add(delta),
        },
    }
}

#[derive(Debug)]
pub struct Subset {
    pub bytes: Vec<u8>,
    /// What it stands for and its advance, in thousandths of the size, for every glyph but those that are only parts of others.
    pub glyphs: BTreeMap<u16, (String, f32)>,
    /// New number of every glyph kept, by its number in the whole font.
    pub numbers: BTreeMap<u16, u16>,
    /// Units of the font for its size.
    pub units_per_em: u16,
}

const COMPONENT: (u16, u16, u16, u16, u16, u16) = (0x1, 0x8, 0x20, 0x40, 0x80, 0x100);

/// Offsets of the components' glyph numbers in a composite glyph, and where its instructions begin.
fn components(data: &[u8]) -> (Vec<usize>, usize) {
    let (words, scale, more, two, four, _) = COMPONENT;
    let (mut at, mut all) = (10, Vec::new());
    loop {
        let flags = u16_at(data, at);
        all.push(at + 2);
        at += 4 + if flags & words != 0 { 4 } else { 2 };
        at += [(scale, 2), (two, 4), (four, 8)]
            .iter()
            .filter(|(bit, _)| flags & bit != 0)
            .map(|b| b.1)
            .sum::<usize>();
        if flags & more == 0 || at >= data.len() {
            return (all, at.min(data.len()));
        }
    }
}

/// An outline without its instructions, its components renumbered.
fn outline(data: &[u8], numbers: &BTreeMap<u16, u16>) -> Vec<u8> {
    let contours = u16_at(data, 0) as i16;
    if data.is_empty() {
        return Vec::new();
    }
    let mut copy;
    if contours >= 0 {
        let at = 10 + 2 * contours as usize;
        copy = data[..at].to_vec();
        copy.extend([0, 0]);
        copy.extend(&data[at + 2 + usize::from(u16_at(data, at))..]);
    } else {
        let (places, end) = components(data);
        copy = data[..end].to_vec();
        for at in places {
            let number = numbers.get(&u16_at(data, at)).copied().unwrap_or(0);
            copy[at..at + 2].copy_from_slice(&number.to_be_bytes());
            let flags = u16_at(data, at - 2) & !COMPONENT.5;
            copy[at - 2..at].copy_from_slice(&flags.to_be_bytes());
        }
    }
    copy.resize(copy.len().next_multiple_of(4), 0);
    copy
}

/// The font with the glyphs of `text` and `drawn` alone; what is drawn has ligatures, which stand for several characters.
pub fn subset(font: &[u8], text: &str, drawn: &BTreeMap<u16, String>) -> Subset {
    let [head, hhea, maxp, hmtx, loca, glyf, cmap, os2] =
        [b"head", b"hhea", b"maxp", b"hmtx", b"loca", b"glyf", b"cmap", b"OS/2"]
            .map(|name| table(font, *name));
    let long = u16_at(head, 50) == 1;
    let offset = |k: usize| match long {
        true => u32_at(loca, 4 * k) as usize,
        false => 2 * usize::from(u16_at(loca, 2 * k)),
    };
    let data = |old: u16| glyf.get(offset(old.into())..offset(usize::from(old) + 1)).unwrap_or_default();
    let mut characters: Vec<char> = text.chars().filter(|c| !c.is_control()).collect();
    characters.sort_unstable();
    characters.dedup();
    let characters: Vec<(char, u16)> =
        characters.into_iter().map(|c| (c, glyph(cmap, c))).filter(|(_, g)| *g > 0).collect();
    let mut order = vec![0];
    order.extend(characters.iter().map(|(_, old)| *old).chain(drawn.keys().copied()));
    let mut next = 1;
    while let Some(&old) = order.get(next) {
        if (u16_at(data(old), 0) as i16) < 0 {
            order.extend(components(data(old)).0.iter().map(|&at| u16_at(data(old), at)));
        }
        next += 1;
    }
    let mut seen = std::collections::BTreeSet::new();
    order.retain(|old| seen.insert(*old));
    let numbers: BTreeMap<u16, u16> = order.iter().zip(0..).map(|(old, new)| (*old, new)).collect();

    let (mut new_glyf, mut new_loca, mut new_hmtx) = (Vec::new(), Vec::new(), Vec::new());
    let metrics = usize::from(u16_at(hhea, 34)).max(1);
    let advance = |old: u16| u16_at(hmtx, 4 * usize::from(old).min(metrics - 1));
    for &old in &order {
        new_loca.extend((new_glyf.len() as u32).to_be_bytes());
        new_glyf.extend(outline(data(old), &numbers));
        let bearing = match usize::from(old) {
            k if k < metrics => u16_at(hmtx, 4 * k + 2),
            k => u16_at(hmtx, 4 * metrics + 2 * (k - metrics)),
        };
        new_hmtx.extend(advance(old).to_be_bytes());
        new_hmtx.extend(bearing.to_be_bytes());
    }
    new_loca.extend((new_glyf.len() as u32).to_be_bytes());
    let with = |table: &[u8], at: usize, value: u16| {
        let mut copy = table.to_vec();
        copy[at..at + 2].copy_from_slice(&value.to_be_bytes());
        copy
    };
    let mut new_head = with(head, 50, 1);
    new_head[8..12].fill(0);
    // one table of format 12 for Windows, UCS-4
    let groups = characters.iter().map(|(c, old)| [u32::from(*c), u32::from(*c), u32::from(numbers[old])]);
    let words = [12 << 16, 16 + 12 * characters.len() as u32, 0, characters.len() as u32];
    let mut new_cmap = vec![0, 0, 0, 1, 0, 3, 0, 10, 0, 0, 0, 12];
    new_cmap.extend(words.into_iter().chain(groups.flatten()).flat_map(u32::to_be_bytes));
    let mut post = vec![0; 32];
    post[1] = 3;
    let count = order.len() as u16;
    let bytes = file(&[
        (b"OS/2", os2.to_vec()),
        (b"cmap", new_cmap),
        (b"glyf", new_glyf),
        (b"head", new_head),
        (b"hhea", with(hhea, 34, count)),
        (b"hmtx", new_hmtx),
        (b"loca", new_loca),
        (b"maxp", with(maxp, 4, count)),
        (b"name", names()),
        (b"post", post),
    ]);
    let units_per_em = u16_at(head, 18);
    let thousandths = |old: u16| 1000.0 * f32::from(advance(old)) / f32::from(units_per_em.max(1));
    let mut glyphs: BTreeMap<u16, (String, f32)> =
        drawn.iter().map(|(old, text)| (numbers[old], (text.clone(), thousandths(*old)))).collect();
    for (c, old) in &characters {
        glyphs.insert(numbers[old], (c.to_string(), thousandths(*old)));
    }
    Subset { bytes, glyphs, numbers, units_per_em }
}

/// Family, style, full and PostScript name, for Windows in English.
fn names() -> Vec<u8> {
    let words = [(1, FAMILY), (2, "Regular"), (4, FAMILY), (6, "DejaVuSans")];
    let mut table: Vec<u8> = [0, 4, 6 + 4 * 12].iter().flat_map(|x: &u16| x.to_be_bytes()).collect();
    let mut at = 0;
    for (id, word) in words {
        let length = 2 * word.len() as u16;
        table.extend([3, 1, 0x409, id, length, at].iter().flat_map(|x| x.to_be_bytes()));
        at += length;
    }
    table.extend(words.map(|(_, word)| word).concat().encode_utf16().flat_map(u16::to_be_bytes));
    table
}

/// Tables, in the order of their names, as one font file.
fn file(tables: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let count = tables.len() as u16;
    let power = count.ilog2() as u16;
    let mut head = vec![0, 1, 0, 0];
    head.extend([count, 16 << power, power, 16 * count - (16 << power)].iter().flat_map(|x| x.to_be_bytes()));
    let sum = |bytes: &[u8]| {
        (0..bytes.len()).step_by(4).fold(0_u32, |sum, k| {
            let word = |j: usize| bytes.get(k + j).copied().unwrap_or(0);
            sum.wrapping_add(u32::from_be_bytes([word(0), word(1), word(2), word(3)]))
        })
    };
    let mut body = Vec::new();
    let mut adjustment = 0;
    for (name, table) in tables {
        let at = 12 + 16 * tables.len() + body.len();
        if *name == b"head" {
            adjustment = at + 8;
        }
        head.extend(*name);
        head.extend([sum(table), at as u32, table.len() as u32].iter().flat_map(|x| x.to_be_bytes()));
        body.extend(table);
        body.resize(body.len().next_multiple_of(4), 0);
    }
    head.extend(body);
    let whole = 0xB1B0_AFBA_u32.wrapping_sub(sum(&head));
    head[adjustment..adjustment + 4].copy_from_slice(&whole.to_be_bytes());
    head
}
