//! A figure as PDF: paths, images, and text in the embedded font.

use super::PaperError;
use super::font::Subset;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str};
use resvg::tiny_skia::PathSegment;
use resvg::tiny_skia::Transform;
use resvg::usvg::layout::PositionedGlyph;
use resvg::usvg::{Fill, Group, Image, ImageKind, LineCap, LineJoin, Node, Paint, Path, Stroke, Text, Tree};
use std::collections::BTreeMap;
use std::io::Write;

/// Points of a CSS pixel.
const POINTS: f32 = 0.75;
/// Name of the font in a page's resources, and in the file with the tag of a subset.
const FONT: Name<'static> = Name(b"F");
const BASE_FONT: Name<'static> = Name(b"SDPFIG+DejaVuSans");
const SYSTEM: SystemInfo<'static> =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

fn deflated(bytes: &[u8]) -> Result<Vec<u8>, std::io::Error> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// A page being drawn.
struct Page<'a> {
    content: Content,
    font: &'a Subset,
    /// Distinct opacities, in thousandths.
    opacities: Vec<u32>,
    /// Width, height, and RGB of images.
    images: Vec<(u32, u32, Vec<u8>)>,
}

fn matrix(t: Transform) -> [f32; 6] {
    [t.sx, t.ky, t.kx, t.sy, t.tx, t.ty]
}

impl Page<'_> {
    fn group(&mut self, group: &Group) -> Result<(), String> {
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) => self.path(path),
                Node::Image(image) => self.image(image)?,
                Node::Text(text) => self.text(text)?,
            }
        }
        Ok(())
    }

    fn opacity(&mut self, opacity: f32) {
        let opacity = (1000.0 * opacity).round() as u32;
        let index = self.opacities.iter().position(|own| *own == opacity).unwrap_or(self.opacities.len());
        if index == self.opacities.len() {
            self.opacities.push(opacity);
        }
        self.content.set_parameters(Name(format!("G{index}").as_bytes()));
    }

    fn fill(&mut self, fill: &Fill) {
        self.opacity(fill.opacity().get());
        if let Paint::Color(c) = fill.paint() {
            let [r, g, b] = [c.red, c.green, c.blue].map(|x| f32::from(x) / 255.0);
            self.content.set_fill_rgb(r, g, b);
        }
    }

    fn stroke(&mut self, stroke: &Stroke) {
        self.opacity(stroke.opacity().get());
        if let Paint::Color(c) = stroke.paint() {
            let [r, g, b] = [c.red, c.green, c.blue].map(|x| f32::from(x) / 255.0);
            self.content.set_stroke_rgb(r, g, b);
        }
        self.content.set_line_width(stroke.width().get());
        self.content.set_line_cap(match stroke.linecap() {
            LineCap::Butt => LineCapStyle::ButtCap,
            LineCap::Round => LineCapStyle::RoundCap,
            LineCap::Square => LineCapStyle::ProjectingSquareCap,
        });
        self.content.set_line_join(match stroke.linejoin() {
            LineJoin::Round => LineJoinStyle::RoundJoin,
            LineJoin::Bevel => LineJoinStyle::BevelJoin,
            LineJoin::Miter | LineJoin::MiterClip => LineJoinStyle::MiterJoin,
        });
        let dashes = stroke.dasharray().unwrap_or_default();
        self.content.set_dash_pattern(dashes.iter().copied(), stroke.dashoffset());
    }

    fn outline(&mut self, path: &Path) {
        let mut last = (0.0, 0.0);
        for segment in path.data().segments() {
            match segment {
                PathSegment::MoveTo(p) => {
                    self.content.move_to(p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::LineTo(p) => {
                    self.content.line_to(p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::QuadTo(c, p) => {
                    // the cubic of the same shape
                    let third = |from: f32, control: f32| from + 2.0 / 3.0 * (control - from);
                    self.content.cubic_to(
                        third(last.0, c.x),
                        third(last.1, c.y),
                        third(p.x, c.x),
                        third(p.y, c.y),
                        p.x,
                        p.y,
                    );
                    last = (p.x, p.y);
                }
                PathSegment::CubicTo(a, b, p) => {
                    self.content.cubic_to(a.x, a.y, b.x, b.y, p.x, p.y);
                    last = (p.x, p.y);
                }
                PathSegment::Close => {
                    self.content.close_path();
                }
            }
        }
    }

    fn path(&mut self, path: &Path) {
        if !path.is_visible() {
            return;
        }
        self.content.save_state();
        self.content.transform(matrix(path.abs_transform()));
        if let Some(fill) = path.fill() {
            self.fill(fill);
            self.outline(path);
            self.content.fill_nonzero();
        }
        if let Some(stroke) = path.stroke() {
            self.stroke(stroke);
            self.outline(path);
            self.content.stroke();
        }
        self.content.restore_state();
    }

    fn image(&mut self, image: &Image) -> Result<(), String> {
        let ImageKind::PNG(bytes) = image.kind() else { return Err("an image is no PNG".into()) };
        let decoder = png::Decoder::new(std::io::Cursor::new(bytes.as_slice()));
        let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
        let mut pixels = vec![0; reader.output_buffer_size().unwrap_or(0)];
        let info = reader.next_frame(&mut pixels).map_err(|error| error.to_string())?;
        if info.color_type != png::ColorType::Rgb {
            return Err("an image has other samples than RGB".into());
        }
        let name = format!("I{}", self.images.len());
        let (width, height) = (image.size().width(), image.size().height());
        self.content.save_state();
        self.content.transform(matrix(image.abs_transform()));
        // an image fills the unit square, its first row on top
        self.content.transform([width, 0.0, 0.0, -height, 0.0, height]);
        self.content.x_object(Name(name.as_bytes()));
        self.content.restore_state();
        self.images.push((info.width, info.height, pixels));
        Ok(())
    }

    fn text(&mut self, text: &Text) -> Result<(), String> {
        for span in text.layouted() {
            self.content.save_state();
            if let Some(fill) = &span.fill {
                self.fill(fill);
            }
            self.content.begin_text();
            self.content.set_font(FONT, 1.0);
            let em = f32::from(self.font.units_per_em);
            for glyph in &span.positioned_glyphs {
                let Some(own) = self.font.numbers.get(&number(glyph)) else {
                    return Err(format!("{:?} is not in the embedded font", glyph.text));
                };
                let place = text.abs_transform().pre_concat(glyph.outline_transform()).pre_scale(em, em);
                self.content.set_text_matrix(matrix(place));
                self.content.show(Str(&own.to_be_bytes()));
            }
            self.content.end_text();
            self.content.restore_state();
        }
        Ok(())
    }
}

/// A glyph's number in the whole font; TrueType has 16 bits.
fn number(glyph: &PositionedGlyph) -> u16 {
    u16::try_from(glyph.id.0).unwrap_or(0)
}

/// Every glyph that is drawn, by its number in the whole font, and the characters it stands for.
pub fn glyphs(tree: &Tree) -> BTreeMap<u16, String> {
    fn collect(group: &Group, all: &mut BTreeMap<u16, String>) {
        for node in group.children() {
            match node {
                Node::Group(group) => collect(group, all),
                Node::Text(text) => {
                    let glyphs = text.layouted().iter().flat_map(|span| &span.positioned_glyphs);
                    all.extend(glyphs.map(|glyph| (number(glyph), glyph.text.clone())));
                }
                Node::Path(_) | Node::Image(_) => {}
            }
        }
    }
    let mut all = BTreeMap::new();
    collect(tree.root(), &mut all);
    all
}

pub fn pdf(name: &str, tree: &Tree, font: &Subset) -> Result<Vec<u8>, PaperError> {
    let failed = |reason: String| PaperError::Draw { name: name.into(), reason };
    let (width, height) = (tree.size().width() * POINTS, tree.size().height() * POINTS);
    let mut page = Page { content: Content::new(), font, opacities: Vec::new(), images: Vec::new() };
    page.content.transform([POINTS, 0.0, 0.0, -POINTS, 0.0, height]);
    page.group(tree.root()).map_err(failed)?;
    let Page { content, opacities, images, .. } = page;

    let [catalog, pages, sheet, stream, font_ref, cid, descriptor, file, cmap] =
        std::array::from_fn(|k| Ref::new(k as i32 + 1));
    let state = |k: usize| Ref::new(10 + k as i32);
    let picture = |k: usize| Ref::new(10 + (opacities.len() + k) as i32);
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([sheet]).count(1);
    let mut leaf = pdf.page(sheet);
    leaf.parent(pages).media_box(Rect::new(0.0, 0.0, width, height)).contents(stream);
    let mut resources = leaf.resources();
    resources.fonts().pair(FONT, font_ref);
    let mut states = resources.ext_g_states();
    for k in 0..opacities.len() {
        states.pair(Name(format!("G{k}").as_bytes()), state(k));
    }
    states.finish();
    let mut objects = resources.x_objects();
    for k in 0..images.len() {
        objects.pair(Name(format!("I{k}").as_bytes()), picture(k));
    }
    objects.finish();
    resources.finish();
    leaf.finish();
    let deflate = |bytes: &[u8]| deflated(bytes).map_err(|error| failed(error.to_string()));
    pdf.stream(stream, &deflate(content.finish().as_slice())?).filter(Filter::FlateDecode);

    pdf.type0_font(font_ref)
        .base_font(BASE_FONT)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(cid)
        .to_unicode(cmap);
    let mut descendant = pdf.cid_font(cid);
    descendant
        .subtype(CidFontType::Type2)
        .base_font(BASE_FONT)
        .system_info(SYSTEM)
        .font_descriptor(descriptor);
    descendant.cid_to_gid_map_predefined(Name(b"Identity"));
    let mut widths = descendant.widths();
    for (number, (_, advance)) in &font.glyphs {
        widths.consecutive(*number, [*advance]);
    }
    widths.finish();
    descendant.finish();
    // as the font's tables head, hhea and OS/2 state them, in thousandths of its size
    pdf.font_descriptor(descriptor)
        .name(BASE_FONT)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(-1021.0, -463.0, 1793.0, 1233.0))
        .italic_angle(0.0)
        .ascent(928.0)
        .descent(-236.0)
        .cap_height(729.0)
        .stem_v(80.0)
        .font_file2(file);
    pdf.stream(file, &deflate(&font.bytes)?)
        .filter(Filter::FlateDecode)
        .pair(Name(b"Length1"), font.bytes.len() as i32);
    let mut unicode = UnicodeCmap::new(Name(b"sdp3"), SYSTEM);
    for (number, (text, _)) in font.glyphs.iter().filter(|(_, (text, _))| !text.is_empty()) {
        unicode.pair_with_multiple(*number, text.chars());
    }
    pdf.cmap(cmap, &unicode.finish());
    for (k, opacity) in opacities.iter().enumerate() {
        let share = *opacity as f32 / 1000.0;
        pdf.ext_graphics(state(k)).non_stroking_alpha(share).stroking_alpha(share);
    }
    for (k, (width, height, pixels)) in images.iter().enumerate() {
        let bytes = deflate(pixels)?;
        let mut image = pdf.image_xobject(picture(k), &bytes);
        image.width(*width as i32).height(*height as i32).bits_per_component(8).filter(Filter::FlateDecode);
        image.color_space().device_rgb();
    }
    Ok(pdf.finish())
}
