//! Writes FlatBuffers: a tree of tables, vectors and strings as bytes.
//!
//! FlatBuffers binary format ("Internals" of its documentation): every reference points forwards, a table begins with
//! the distance back to its vtable, everything is aligned to its own size and binary data to 16 bytes.

/// A value of a table's field.
pub enum Field {
    /// `byte`, `ubyte` or `bool`.
    U8(u8),
    I32(i32),
    /// A table, vector or string.
    Ref(Node),
}

/// Something a field can refer to.
pub enum Node {
    /// Fields by their number in the schema.
    Table(Vec<(usize, Field)>),
    /// A vector of tables or strings.
    Nodes(Vec<Node>),
    /// A vector of `ubyte`, aligned to 16 bytes.
    Bytes(Vec<u8>),
    /// A vector of `int`.
    I32s(Vec<i32>),
    /// A vector of `long`.
    I64s(Vec<i64>),
    /// A vector of `float`.
    F32s(Vec<f32>),
    Text(String),
}

/// A whole file with its root table and four-byte identifier.
pub fn finish(root: Node, identifier: [u8; 4]) -> Vec<u8> {
    let mut out = Writer(vec![0; 4]);
    out.0.extend_from_slice(&identifier);
    out.refer(0, root);
    out.0.resize(out.0.len().next_multiple_of(4), 0);
    out.0
}

struct Writer(Vec<u8>);

impl Writer {
    /// Zeros until a value `ahead` bytes from here would lie on a multiple of `size`.
    fn align(&mut self, size: usize, ahead: usize) {
        self.0.resize((self.0.len() + ahead).next_multiple_of(size) - ahead, 0);
    }

    /// Places a node and writes its distance at `from`.
    fn refer(&mut self, from: usize, node: Node) {
        let at = self.place(node);
        self.0[from..from + 4].copy_from_slice(&((at - from) as u32).to_le_bytes());
    }

    fn vector(&mut self, count: usize, align: usize, elements: impl Iterator<Item = u8>) -> usize {
        self.align(align.max(4), 4);
        let at = self.0.len();
        self.0.extend_from_slice(&(count as u32).to_le_bytes());
        self.0.extend(elements);
        at
    }

    /// Writes a node and returns its position.
    fn place(&mut self, node: Node) -> usize {
        match node {
            Node::Table(fields) => self.table(fields),
            Node::Nodes(nodes) => {
                let at = self.vector(nodes.len(), 4, std::iter::repeat_n(0, 4 * nodes.len()));
                for (i, node) in nodes.into_iter().enumerate() {
                    self.refer(at + 4 + 4 * i, node);
                }
                at
            }
            Node::Bytes(values) => self.vector(values.len(), 16, values.into_iter()),
            Node::I32s(values) => self.vector(values.len(), 4, values.iter().flat_map(|v| v.to_le_bytes())),
            Node::I64s(values) => self.vector(values.len(), 8, values.iter().flat_map(|v| v.to_le_bytes())),
            Node::F32s(values) => self.vector(values.len(), 4, values.iter().flat_map(|v| v.to_le_bytes())),
            Node::Text(text) => self.vector(text.len(), 4, text.into_bytes().into_iter().chain([0])),
        }
    }

    fn table(&mut self, fields: Vec<(usize, Field)>) -> usize {
        // words first, then bytes: no gaps
        let (bytes, words): (Vec<_>, Vec<_>) = fields.into_iter().partition(|f| matches!(f.1, Field::U8(_)));
        let slots = words.iter().chain(&bytes).map(|f| f.0 + 1).max().unwrap_or(0);
        let size = 4 + 4 * words.len() + bytes.len();
        let mut vtable = vec![0u16; slots];
        words.iter().enumerate().for_each(|(i, f)| vtable[f.0] = (4 + 4 * i) as u16);
        bytes.iter().enumerate().for_each(|(i, f)| vtable[f.0] = (4 + 4 * words.len() + i) as u16);
        let vtable_size = 4 + 2 * slots;
        self.align(4, vtable_size);
        for value in [vtable_size as u16, size as u16].into_iter().chain(vtable) {
            self.0.extend_from_slice(&value.to_le_bytes());
        }
        let at = self.0.len();
        self.0.extend_from_slice(&(vtable_size as i32).to_le_bytes());
        let mut references = Vec::new();
        for (_, field) in words.into_iter().chain(bytes) {
            match field {
                Field::U8(value) => self.0.push(value),
                Field::I32(value) => self.0.extend_from_slice(&value.to_le_bytes()),
                Field::Ref(node) => {
                    references.push((self.0.len(), node));
                    self.0.extend_from_slice(&[0; 4]);
                }
            }
        }
        for (from, node) in references {
            self.refer(from, node);
        }
        at
    }
}
