#include "common/scene/patch_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "common/util/bytes.h"
#include "common/util/file.h"

namespace isolux {
namespace {

constexpr std::string_view kMagic = "ply";
constexpr std::string_view kFormat = "format binary_little_endian 1.0";
constexpr std::string_view kComment = "comment isolux ";
constexpr std::string_view kBand = "band ";  // after kComment: its number, low_nm, high_nm
constexpr std::string_view kEnd = "end_header";
constexpr size_t kLongestLine = 1 << 20;
constexpr size_t kMostComments = 1 << 16;
constexpr uint64_t kMostItems = 1ULL << 31;  // vertices or faces
// Beyond this ratio of offset to extent a float no longer separates the vertices of a fine mesh.
constexpr double kFloatOffset = 1000;

// What varies in the layout; all else is fixed.
struct Layout {
  bool double_positions = false;
  bool long_lists = false;  // a face has more than 255 vertices
  uint64_t vertices = 0, faces = 0;
  uint64_t bands = 0;

  uint64_t BandBytes() const { return 2 * bands * sizeof(float); }
  uint64_t VertexBytes() const { return (double_positions ? 24 : 12) + 3 + 24 + BandBytes(); }
  uint64_t FaceBytes() const {  // without the list
    return (long_lists ? 4 : 1) + 36 + 4 + 4 + 4 + 1 + 8 + BandBytes();
  }
};

// The header after the comments, one entry a line.
std::vector<std::string> HeaderLines(const Layout& layout) {
  std::vector<std::string> lines;
  const auto floats = [&](std::initializer_list<const char*> groups) {
    for (const char* group : groups) {
      for (const char channel : {'r', 'g', 'b'}) {
        lines.push_back(fmt::format("property float {}_{}", group, channel));
      }
    }
  };
  const auto bands = [&] {
    for (const char* group : {"radiosity", "irradiance"}) {
      for (uint64_t b = 1; b <= layout.bands; ++b) {
        lines.push_back(fmt::format("property float {}_band_{}", group, b));
      }
    }
  };
  lines.push_back(fmt::format("element vertex {}", layout.vertices));
  for (const char axis : {'x', 'y', 'z'}) {
    lines.push_back(
        fmt::format("property {} {}", layout.double_positions ? "double" : "float", axis));
  }
  for (const char* colour : {"red", "green", "blue"}) {
    lines.push_back(fmt::format("property uchar {}", colour));
  }
  floats({"radiosity", "irradiance"});
  bands();
  lines.push_back(fmt::format("element face {}", layout.faces));
  lines.push_back(
      fmt::format("property list {} uint vertex_indices", layout.long_lists ? "uint" : "uchar"));
  floats({"radiosity", "irradiance", "emission"});
  for (const char* property : {"float error", "uint polygon", "uint surface", "uchar side",
                               "uint path_low", "uint path_high"}) {
    lines.push_back(fmt::format("property {}", property));
  }
  bands();
  return lines;
}

// A comment is one line: control characters become spaces; a key has no blanks.
std::string OneLine(std::string text, bool is_key) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    if (is_key && c == ' ') c = '_';
  }
  return text;
}

double Luminance(const std::array<float, 3>& c) {
  return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

// Radiosity as the colours mesh viewers show: an exponential curve by which all but the brightest
// twentieth of the lit vertices stay clearly below white.
class ViewerColours {
 public:
  explicit ViewerColours(const std::vector<PatchVertex>& vertices) {
    std::vector<double> lit;
    for (const PatchVertex& v : vertices) {
      const double luminance = Luminance(v.radiosity);
      if (luminance > 0) lit.push_back(luminance);
    }
    if (lit.empty()) return;
    const size_t place = lit.size() * 95 / 100;
    std::nth_element(lit.begin(), lit.begin() + static_cast<std::ptrdiff_t>(place), lit.end());
    scale_ = 1.8 / lit[place];
  }

  std::array<uint8_t, 3> Of(const std::array<float, 3>& radiosity) const {
    std::array<uint8_t, 3> colour{};
    for (int c = 0; c < 3; ++c) {
      const double linear = 1 - std::exp(-scale_ * std::max(0.0F, radiosity[c]));
      const double encoded =
          linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
      colour[c] = static_cast<uint8_t>(std::lround(255 * std::clamp(encoded, 0.0, 1.0)));
    }
    return colour;
  }

 private:
  double scale_ = 0;
};

Layout LayoutOf(const PatchFile& file) {
  Layout layout;
  layout.vertices = file.vertices.size();
  layout.faces = file.faces.size();
  layout.bands = file.bands.size();
  Bounds3 bounds;
  for (const PatchVertex& v : file.vertices) bounds.Add(v.position);
  if (!bounds.Empty()) {
    layout.double_positions =
        glm::length(bounds.Centre()) > kFloatOffset * std::max(bounds.Diagonal(), 1e-300);
  }
  layout.long_lists = std::any_of(file.faces.begin(), file.faces.end(),
                                  [](const PatchFace& f) { return f.vertices.size() > 255; });
  return layout;
}

void Put(ByteWriter& out, const std::array<float, 3>& values) {
  for (const float value : values) out.Put(value);
}

std::array<float, 3> GetFloats(ByteReader& in) {
  std::array<float, 3> values{};
  for (float& value : values) value = in.Get<float>();
  return values;
}

void Put(ByteWriter& out, const BandValues& of, size_t item, size_t bands) {
  const size_t begin = 2 * bands * item;
  for (size_t i = begin; i < begin + 2 * bands; ++i) out.Put(of.values[i]);
}

// False where one is no number.
bool AppendBands(ByteReader& in, size_t bands, BandValues* to) {
  bool finite = true;
  for (size_t i = 0; i < 2 * bands; ++i) {
    to->values.push_back(in.Get<float>());
    finite = finite && std::isfinite(to->values.back());
  }
  return finite;
}

bool Finite(const std::array<float, 3>& values) {
  return std::isfinite(values[0]) && std::isfinite(values[1]) && std::isfinite(values[2]);
}

// Walks the header line by line; knows where it is, for messages.
class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}

  Result<std::string_view> Line() {
    ++number_;
    const size_t end = rest_.substr(0, kLongestLine).find('\n');
    if (end == std::string_view::npos) {
      return Fail(number_ == 1 ? "not a PLY file" : "the header breaks off");
    }
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    return line;
  }

  Status Expect(std::string_view expected) {
    ASSIGN_OR_RETURN(const std::string_view line, Line());
    if (line == expected) return {};
    return ToStatus(Fail(fmt::format("expected '{}', not '{}'", expected, line.substr(0, 80))));
  }

  tl::unexpected<Status> Fail(const std::string& what) const {
    return Error(StatusCode::kInvalidArgument,
                 "{}:{}: not a patch file of Isolux: {}; fetch or solve it again", name_, number_,
                 what);
  }
  static Status ToStatus(const tl::unexpected<Status>& error) { return error.value(); }

  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  const std::string& name_;
  int number_ = 0;
};

// The unsigned number after `prefix`, which ends the line.
bool ParseCount(std::string_view line, std::string_view prefix, uint64_t* count) {
  if (!line.starts_with(prefix)) return false;
  line.remove_prefix(prefix.size());
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), *count);
  return error == std::errc() && end == line.data() + line.size() && *count <= kMostItems;
}

// The band after `count` others: its number, from 1, and its wavelengths, in nm.
bool ParseBand(std::string_view line, size_t count, Band* band) {
  const std::string start = fmt::format("{}{} ", kBand, count + 1);
  if (!line.starts_with(start)) return false;
  const char* end = line.data() + line.size();
  const auto low = std::from_chars(line.data() + start.size(), end, band->low_nm);
  if (low.ec != std::errc() || low.ptr == end || *low.ptr != ' ') return false;
  const auto high = std::from_chars(low.ptr + 1, end, band->high_nm);
  return high.ec == std::errc() && high.ptr == end && band->low_nm > 0 &&
         band->high_nm > band->low_nm;
}

// Reads the header's variable parts, then checks the rest of it against what Encode writes.
Result<Layout> ReadHeader(HeaderReader& header, PatchFile* file) {
  RETURN_IF_ERROR(header.Expect(kMagic));
  RETURN_IF_ERROR(header.Expect(kFormat));
  ASSIGN_OR_RETURN(std::string_view line, header.Line());
  while (line.starts_with(kComment)) {
    line.remove_prefix(kComment.size());
    if (line.starts_with(kBand)) {
      Band band;
      if (file->bands.size() == kMostBands || !ParseBand(line, file->bands.size(), &band)) {
        return header.Fail("a spectral band is not told as 'band NUMBER LOW HIGH'");
      }
      file->bands.push_back(band);
      ASSIGN_OR_RETURN(line, header.Line());
      continue;
    }
    const size_t blank = line.find(' ');
    if (file->comments.size() == kMostComments) return header.Fail("too many comments");
    if (blank == 0 || blank == std::string_view::npos) return header.Fail("a comment has no value");
    file->comments.emplace_back(line.substr(0, blank), line.substr(blank + 1));
    ASSIGN_OR_RETURN(line, header.Line());
  }
  Layout layout;
  layout.bands = file->bands.size();
  if (!ParseCount(line, "element vertex ", &layout.vertices)) {
    return header.Fail("expected 'element vertex COUNT'");
  }
  ASSIGN_OR_RETURN(line, header.Line());
  layout.double_positions = line.starts_with("property double");
  bool first = true;
  std::vector<std::string> expected = HeaderLines(layout);
  for (size_t i = 1; i < expected.size(); ++i) {
    if (!first) {
      ASSIGN_OR_RETURN(line, header.Line());
    }
    first = false;
    if (expected[i].starts_with("element face")) {
      if (!ParseCount(line, "element face ", &layout.faces)) {
        return header.Fail("expected 'element face COUNT'");
      }
    } else if (line.starts_with("property list uint ")) {
      layout.long_lists = true;
      expected = HeaderLines(layout);
    }
    if (!expected[i].starts_with("element face") && line != expected[i]) {
      return header.Fail(fmt::format("expected '{}'", expected[i]));
    }
  }
  RETURN_IF_ERROR(header.Expect(kEnd));
  return layout;
}

Status ReadVertices(ByteReader& in, const Layout& layout, const std::string& name,
                    PatchFile* file) {
  if (!in.Holds(layout.vertices, layout.VertexBytes())) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: breaks off: {} vertices announced, {} bytes left; fetch it again", name,
                      layout.vertices, in.left());
  }
  file->vertices.resize(layout.vertices);
  for (uint64_t i = 0; i < layout.vertices; ++i) {
    PatchVertex& v = file->vertices[i];
    for (int d = 0; d < 3; ++d) {
      v.position[d] =
          layout.double_positions ? in.Get<double>() : static_cast<double>(in.Get<float>());
    }
    in.GetBytes(3);
    v.radiosity = GetFloats(in);
    v.irradiance = GetFloats(in);
    const bool finite = std::isfinite(v.position.x) && std::isfinite(v.position.y) &&
                        std::isfinite(v.position.z) && Finite(v.radiosity) &&
                        Finite(v.irradiance) && AppendBands(in, layout.bands, &file->vertex_bands);
    if (!finite) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "{}: vertex {} holds what is no number; fetch or solve it again", name, i);
    }
  }
  return {};
}

Status ReadFace(ByteReader& in, const Layout& layout, PatchFace* face, BandValues* bands) {
  const uint64_t count = layout.long_lists ? in.Get<uint32_t>() : in.Get<uint8_t>();
  const auto fail = [](const char* what) { return Status(StatusCode::kInvalidArgument, what); };
  if (!in.Holds(count, 4)) return fail("breaks off");
  if (count < 3) return fail("has fewer than three vertices");
  face->vertices.resize(count);
  for (uint32_t& vertex : face->vertices) {
    vertex = in.Get<uint32_t>();
    if (vertex >= layout.vertices) return fail("names a vertex that is not there");
  }
  face->radiosity = GetFloats(in);
  face->irradiance = GetFloats(in);
  face->emission = GetFloats(in);
  face->error = in.Get<float>();
  face->polygon = in.Get<uint32_t>();
  face->surface = in.Get<uint32_t>();
  face->side = in.Get<uint8_t>();
  const uint64_t low = in.Get<uint32_t>();
  face->path = low | static_cast<uint64_t>(in.Get<uint32_t>()) << 32;
  const bool finite_bands = AppendBands(in, layout.bands, bands);
  if (!in.ok()) return fail("breaks off");
  if (!Finite(face->radiosity) || !Finite(face->irradiance) || !Finite(face->emission) ||
      !std::isfinite(face->error) || !finite_bands) {
    return fail("holds what is no number");
  }
  if (face->side > 1) return fail("has a side that is neither 0 nor 1");
  if (face->path == 0) return fail("has path 0");
  return {};
}

}  // namespace

std::string PatchFile::Comment(const std::string& key) const {
  for (const auto& [name, value] : comments) {
    if (name == key) return value;
  }
  return {};
}

std::string Encode(const PatchFile& file) {
  const Layout layout = LayoutOf(file);
  uint64_t list_bytes = 0;
  for (const PatchFace& face : file.faces) list_bytes += 4 * face.vertices.size();
  ByteWriter out(4096 + layout.vertices * layout.VertexBytes() + layout.faces * layout.FaceBytes() +
                 list_bytes);
  const auto line = [&](std::string_view text) {
    out.PutBytes(text);
    out.PutBytes("\n");
  };
  line(kMagic);
  line(kFormat);
  for (const auto& [key, value] : file.comments) {
    line(fmt::format("{}{} {}", kComment, OneLine(key, true), OneLine(value, false)));
  }
  for (size_t b = 0; b < file.bands.size(); ++b) {
    line(fmt::format("{}{}{} {} {}", kComment, kBand, b + 1, file.bands[b].low_nm,
                     file.bands[b].high_nm));
  }
  for (const std::string& text : HeaderLines(layout)) line(text);
  line(kEnd);

  const ViewerColours colours(file.vertices);
  for (size_t i = 0; i < file.vertices.size(); ++i) {
    const PatchVertex& v = file.vertices[i];
    for (int d = 0; d < 3; ++d) {
      if (layout.double_positions) {
        out.Put(v.position[d]);
      } else {
        out.Put(static_cast<float>(v.position[d]));
      }
    }
    for (const uint8_t value : colours.Of(v.radiosity)) out.Put(value);
    Put(out, v.radiosity);
    Put(out, v.irradiance);
    Put(out, file.vertex_bands, i, file.bands.size());
  }
  for (size_t i = 0; i < file.faces.size(); ++i) {
    const PatchFace& face = file.faces[i];
    if (layout.long_lists) {
      out.Put(static_cast<uint32_t>(face.vertices.size()));
    } else {
      out.Put(static_cast<uint8_t>(face.vertices.size()));
    }
    for (const uint32_t vertex : face.vertices) out.Put(vertex);
    Put(out, face.radiosity);
    Put(out, face.irradiance);
    Put(out, face.emission);
    out.Put(face.error);
    out.Put(face.polygon);
    out.Put(face.surface);
    out.Put(face.side);
    out.Put(static_cast<uint32_t>(face.path));
    out.Put(static_cast<uint32_t>(face.path >> 32));
    Put(out, file.face_bands, i, file.bands.size());
  }
  return out.Take();
}

Result<PatchFile> DecodePatchFile(const std::string& bytes, const std::string& name) {
  PatchFile file;
  HeaderReader header(bytes, name);
  ASSIGN_OR_RETURN(const Layout layout, ReadHeader(header, &file));
  ByteReader in(header.rest());
  RETURN_IF_ERROR(ReadVertices(in, layout, name, &file));
  if (!in.Holds(layout.faces, layout.FaceBytes() + 12)) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: breaks off: {} faces announced, {} bytes left; fetch it again", name,
                 layout.faces, in.left());
  }
  file.faces.resize(layout.faces);
  for (uint64_t i = 0; i < layout.faces; ++i) {
    const Status status = ReadFace(in, layout, &file.faces[i], &file.face_bands);
    if (!status.ok()) {
      return Error(status.code(), "{}: face {} {}; fetch or solve it again", name, i,
                   status.message());
    }
  }
  if (in.left() != 0) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: {} bytes too many after the last face; fetch it again", name, in.left());
  }
  return file;
}

Status WritePatchFile(const PatchFile& file, const std::string& path) {
  return WriteFileDurably(path, Encode(file));
}

Result<PatchFile> ReadPatchFile(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  return DecodePatchFile(bytes, path);
}

}  // namespace isolux
