#include "client/import/obj_reader.h"

#include <tiny_obj_loader.h>

#include <istream>
#include <set>
#include <streambuf>
#include <unordered_map>

#include "client/import/mtl_reader.h"
#include "client/import/text_file.h"
#include "common/util/file.h"

namespace isolux {
namespace {

constexpr uint64_t kMostSceneBytes = 4ULL << 30;
constexpr uint32_t kMostCorners = 2048;  // of a face; dividing it takes time with the cube of it
constexpr size_t kMostLibraries = 1024;

// A stream over the text that tells how far it was read, so that a callback knows its line.
class TextBuffer : public std::streambuf {
 public:
  explicit TextBuffer(std::string& text) {
    setg(text.data(), text.data(), text.data() + text.size());
  }
  size_t position() const { return static_cast<size_t>(gptr() - eback()); }
};

struct MaterialUse {
  std::string name;
  uint32_t line = 0;  // of the first usemtl
};

// Receives the parser's callbacks. The first error stays; what follows is ignored.
class Reader {
 public:
  Reader(CleanText text, const std::string& path, const SceneLimits& limits)
      : text_(std::move(text)), buffer_(text_.text()), limits_(limits) {
    file_.path = path;
  }

  Result<SceneFile> Read();

 private:
  class LibraryReader;

  void AddPoint();
  void AddFace(const tinyobj::index_t* indices, int count);
  // Of the corner just added; `index` as in the file, 0 for none.
  void AddCoordinates(int64_t index);
  void UseMaterial(const char* name);
  void AddLibraries();
  void AddLibrary(const std::string& name);
  Status ResolveMaterials();

  uint32_t Line() { return text_.LineBefore(buffer_.position()); }
  std::string Where(uint32_t line) const { return fmt::format("{}:{}", file_.path, line); }
  // The line just read, without its keyword.
  std::string_view LineText() const;
  template <typename... Args>
  void Fail(StatusCode code, fmt::format_string<Args...> format, Args&&... args) {
    if (!status_.ok()) return;
    status_ = Status(code, Where(Line()) + ": " + fmt::format(format, std::forward<Args>(args)...));
  }

  CleanText text_;
  TextBuffer buffer_;
  SceneLimits limits_;
  SceneFile file_;
  Status status_;
  std::vector<MaterialUse> uses_;  // FileFace::material is an index into these until resolved
  std::unordered_map<std::string, uint32_t> use_of_;
  uint32_t use_ = kNoMaterial;
  std::unordered_map<std::string, uint32_t> material_of_;
  std::set<std::string> loaded_;                           // libraries by path
  std::vector<std::pair<std::string, uint32_t>> missing_;  // libraries by name, and line
  uint32_t library_line_ = 0;                              // of the mtllib line handled last
};

// The parser asks for one library after the other until one is there, though all that a line names
// count. So the first question about a line loads them all, and the answer is always no.
class Reader::LibraryReader : public tinyobj::MaterialReader {
 public:
  explicit LibraryReader(Reader* reader) : reader_(reader) {}
  bool operator()(const std::string&, std::vector<tinyobj::material_t>*,
                  std::map<std::string, int>*, std::string*, std::string*) override {
    reader_->AddLibraries();
    return false;
  }

 private:
  Reader* reader_;
};

std::string_view Reader::LineText() const {
  const std::string& text = text_.text();
  size_t end = buffer_.position();
  if (end > 0 && text[end - 1] == '\n') --end;
  const size_t previous = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
  const size_t start = previous == std::string::npos ? 0 : previous + 1;
  std::string_view line = Trim(std::string_view(text).substr(start, end - start));
  line.remove_prefix(std::min(line.find_first_of(" \t"), line.size()));
  return Trim(line);
}

void Reader::AddPoint() {
  if (!status_.ok()) return;
  if (file_.points.size() >= limits_.vertices) {
    return Fail(StatusCode::kResourceExhausted, "more than {} vertices; simplify the scene",
                limits_.vertices);
  }
  std::string_view rest = LineText();
  Vec3 point(0.0);
  for (int i = 0; i < 3; ++i) {
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
    const std::optional<double> value = ParseNumber(word);
    if (!value) {
      return Fail(StatusCode::kInvalidArgument,
                  "a vertex needs three finite numbers, '{}' is not one; correct the line", word);
    }
    point[i] = *value;
    rest = Trim(rest.substr(word.size()));
  }
  file_.points.push_back(point);
}

// Whether a corner is of the form 1, 1/2, 1//3 or 1/2/3 with numbers that fit.
bool IsCorner(std::string_view word) {
  int digits = 0;
  int slashes = 0;
  for (size_t i = 0; i < word.size(); ++i) {
    const char c = word[i];
    if (c == '/') {
      if (slashes == 0 && digits == 0) return false;
      if (++slashes > 2) return false;
      digits = 0;
    } else if (c == '-' || c == '+') {
      if (digits > 0) return false;
    } else if (c < '0' || c > '9' || ++digits > 9) {
      return false;
    }
  }
  return digits > 0 || slashes > 0;
}

void Reader::AddFace(const tinyobj::index_t* indices, int count) {
  if (!status_.ok()) return;
  if (file_.faces.size() >= limits_.polygons) {
    return Fail(StatusCode::kResourceExhausted, "more than {} faces; simplify the scene",
                limits_.polygons);
  }
  const auto words = Words(LineText());
  if (count < 3 || words.size() < 3) {
    return Fail(StatusCode::kInvalidArgument,
                "a face needs at least 3 corners, this one has {}; mend or delete the line",
                words.size());
  }
  if (words.size() > kMostCorners) {
    return Fail(StatusCode::kResourceExhausted,
                "a face with {} corners, more than {}; divide it into smaller ones", words.size(),
                kMostCorners);
  }
  FileFace face{file_.corners.size(), static_cast<uint32_t>(words.size()), Line(), use_};
  const auto points = static_cast<int64_t>(file_.points.size());
  for (size_t i = 0; i < words.size(); ++i) {
    if (!IsCorner(words[i]) || i >= static_cast<size_t>(count)) {
      return Fail(StatusCode::kInvalidArgument,
                  "'{}' is not a corner of a face (1, 1/2, 1//3 or 1/2/3); correct the line",
                  words[i]);
    }
    const int64_t index = indices[i].vertex_index;
    const int64_t number = index < 0 ? points + index : index - 1;
    if (index == 0 || number < 0 || number >= points) {
      return Fail(StatusCode::kInvalidArgument,
                  "corner '{}' names a vertex that is not there: {} stand above this line; is the "
                  "file whole?",
                  words[i], points);
    }
    file_.corners.push_back(static_cast<uint32_t>(number));
    AddCoordinates(indices[i].texcoord_index);
  }
  file_.faces.push_back(face);
}

void Reader::AddCoordinates(int64_t index) {
  const auto count = static_cast<int64_t>(file_.coordinates.size());
  const int64_t number = index < 0 ? count + index : index - 1;
  const bool known = index != 0 && number >= 0 && number < count;
  file_.corner_coordinates.push_back(known ? static_cast<uint32_t>(number) : kNoCoordinates);
}

void Reader::UseMaterial(const char* name) {
  const std::string trimmed(Trim(name));
  const auto [at, is_new] = use_of_.emplace(trimmed, static_cast<uint32_t>(uses_.size()));
  if (is_new) uses_.push_back({trimmed, Line()});
  use_ = at->second;
}

void Reader::AddLibraries() {
  if (!status_.ok() || library_line_ == Line()) return;
  library_line_ = Line();
  const std::string whole(LineText());  // a name may hold blanks
  if (!FindFile(FolderOf(file_.path), whole).empty()) return AddLibrary(whole);
  for (const std::string_view name : Words(whole)) AddLibrary(std::string(name));
}

void Reader::AddLibrary(const std::string& name) {
  const std::string path = FindFile(FolderOf(file_.path), name);
  if (path.empty()) {
    if (missing_.size() < kMostLibraries) missing_.emplace_back(name, Line());
    return;
  }
  if (!loaded_.insert(path).second) return;
  if (loaded_.size() > kMostLibraries) {
    return Fail(StatusCode::kResourceExhausted, "more than {} material libraries", kMostLibraries);
  }
  Result<std::vector<FileMaterial>> materials = ReadMtl(path);
  if (!materials.has_value()) {
    if (status_.ok()) status_ = materials.error();
    return;
  }
  for (FileMaterial& material : *materials) {
    const auto number = static_cast<uint32_t>(file_.materials.size());
    if (!material_of_.emplace(material.name, number).second) {
      file_.repeated_materials.push_back(material.where);
      continue;
    }
    file_.materials.push_back(std::move(material));
  }
}

Status Reader::ResolveMaterials() {
  for (FileFace& face : file_.faces) {
    if (face.material == kNoMaterial) continue;
    const MaterialUse& use = uses_[face.material];
    const auto found = material_of_.find(use.name);
    if (found != material_of_.end()) {
      face.material = found->second;
      continue;
    }
    if (missing_.empty()) {
      return MakeStatus(StatusCode::kNotFound,
                        "{}: material '{}' is in no material library of the file; add it to the "
                        "MTL file or correct the name",
                        Where(use.line), use.name);
    }
    return MakeStatus(StatusCode::kNotFound,
                      "{}: material '{}' is missing, as is the library '{}' ({}); put that file "
                      "beside the scene or correct the mtllib line",
                      Where(use.line), use.name, missing_[0].first, Where(missing_[0].second));
  }
  for (const auto& [name, line] : missing_) file_.missing_libraries.push_back(Where(line));
  return {};
}

Result<SceneFile> Reader::Read() {
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = [](void* self, tinyobj::real_t, tinyobj::real_t, tinyobj::real_t,
                           tinyobj::real_t) { static_cast<Reader*>(self)->AddPoint(); };
  callbacks.texcoord_cb = [](void* self, tinyobj::real_t u, tinyobj::real_t v, tinyobj::real_t) {
    SceneFile& file = static_cast<Reader*>(self)->file_;
    const uint64_t most = static_cast<Reader*>(self)->limits_.vertices;
    if (file.coordinates.size() < most) file.coordinates.emplace_back(u, 1 - v);
  };
  callbacks.index_cb = [](void* self, tinyobj::index_t* indices, int count) {
    static_cast<Reader*>(self)->AddFace(indices, count);
  };
  callbacks.usemtl_cb = [](void* self, const char* name, int) {
    static_cast<Reader*>(self)->UseMaterial(name);
  };
  LibraryReader libraries(this);
  std::istream stream(&buffer_);
  std::string warnings, errors;
  tinyobj::LoadObjWithCallback(stream, callbacks, this, &libraries, &warnings, &errors);
  RETURN_IF_ERROR(status_);
  if (file_.faces.empty()) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: no faces in the file; is it a Wavefront OBJ, and whole?", file_.path);
  }
  RETURN_IF_ERROR(ResolveMaterials());
  return std::move(file_);
}

}  // namespace

Result<SceneFile> ReadObj(const std::string& path, const SceneLimits& limits) {
  ASSIGN_OR_RETURN(std::string bytes, ReadFile(path, kMostSceneBytes));
  return ParseObj(std::move(bytes), path, limits);
}

Result<SceneFile> ParseObj(std::string bytes, const std::string& path, const SceneLimits& limits) {
  ASSIGN_OR_RETURN(CleanText text, CleanText::FromBytes(std::move(bytes), path));
  Reader reader(std::move(text), path, limits);
  return reader.Read();
}

}  // namespace isolux
