#include "client/import/mtl_reader.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>

#include "client/import/text_file.h"
#include "common/util/file.h"

namespace isolux {
namespace {

constexpr uint64_t kMostMtlBytes = 64ULL << 20;
constexpr size_t kMostMaterials = 65'536;
constexpr double kMostLeaves = 0.98;  // a fluorescent surface, of what arrives

// Colours with the line they stand in: the library takes what is no number for 0 and knows no
// lines.
struct ScannedMaterial {
  uint32_t line = 0;
  std::optional<Rgb> kd, ke, ks, td, tf, fl;
};

Result<Rgb> ParseColour(const std::vector<std::string_view>& words, const std::string& where) {
  Rgb colour(0.0);
  const size_t count = words.size() - 1;
  if (count != 1 && count != 3) {
    return Error(StatusCode::kInvalidArgument, "{}: {} needs one or three numbers", where,
                 words[0]);
  }
  for (size_t c = 0; c < 3; ++c) {
    const std::string_view word = words[1 + std::min(c, count - 1)];
    const std::optional<double> value = ParseNumber(word);
    if (!value || *value < 0) {
      return Error(StatusCode::kInvalidArgument,
                   "{}: {} '{}' is not a number of 0 or more; correct the line", where, words[0],
                   word);
    }
    colour[static_cast<int>(c)] = *value;
  }
  return colour;
}

Result<std::vector<ScannedMaterial>> Scan(CleanText& file) {
  std::vector<ScannedMaterial> materials;
  const std::string& text = file.text();
  for (size_t start = 0; start < text.size();) {
    const size_t end = std::min(text.find('\n', start), text.size());
    const auto words = Words(std::string_view(text).substr(start, end - start));
    start = end + 1;
    if (words.empty()) continue;
    const auto where = [&] { return fmt::format("{}:{}", file.name(), file.LineBefore(end)); };
    if (words[0] == "newmtl") {
      if (words.size() < 2) {
        return Error(StatusCode::kInvalidArgument, "{}: newmtl without a name", where());
      }
      if (materials.size() >= kMostMaterials) {
        return Error(StatusCode::kResourceExhausted, "{}: more than {} materials", where(),
                     kMostMaterials);
      }
      materials.push_back({file.LineBefore(end), {}, {}, {}, {}, {}, {}});
    } else if (words[0] == "Kd" || words[0] == "Ke" || words[0] == "Ks" || words[0] == "Td" ||
               words[0] == "Tf" || words[0] == "Fl") {
      if (materials.empty()) {
        return Error(StatusCode::kInvalidArgument, "{}: {} before the first newmtl", where(),
                     words[0]);
      }
      ASSIGN_OR_RETURN(const Rgb colour, ParseColour(words, where()));
      if (words[0] == "Fl" && words.size() != 4) {
        return Error(
            StatusCode::kInvalidArgument,
            "{}: Fl needs three numbers: what of blue becomes green, of blue red, of green "
            "red",
            where());
      }
      ScannedMaterial& material = materials.back();
      (words[0] == "Kd"   ? material.kd
       : words[0] == "Ke" ? material.ke
       : words[0] == "Ks" ? material.ks
       : words[0] == "Td" ? material.td
       : words[0] == "Tf" ? material.tf
                          : material.fl) = colour;
    }
  }
  return materials;
}

double Largest(const tinyobj::real_t (&colour)[3]) {
  return std::max({colour[0], colour[1], colour[2]});
}

bool IsGlass(const tinyobj::material_t& m) {
  if (m.dissolve < 0.999) return true;
  // Some exporters write Tf 1 1 1 for opaque materials; there only the illumination model tells.
  const bool filter = Largest(m.transmittance) > 0;
  const bool all = m.transmittance[0] >= 1 && m.transmittance[1] >= 1 && m.transmittance[2] >= 1;
  return filter && (!all || m.illum == 4 || m.illum == 6 || m.illum == 7 || m.illum == 9);
}

// What is not opaque of a glass passes, coloured by its filter; what is opaque of it reflects Kd.
// Without a filter, or with one of nothing as some exporters write it beside d, all of it does.
Status SetGlass(const ScannedMaterial& scanned, const tinyobj::material_t& from,
                FileMaterial* material) {
  const Rgb filter = scanned.tf.value_or(Rgb(0.0));
  const double opaque = std::clamp<double>(from.dissolve, 0, 1);
  const bool dissolves = opaque < 0.999;
  material->clear = dissolves ? (1 - opaque) * (Sum(filter) > 0 ? filter : Rgb(1.0)) : filter;
  material->scattered = dissolves ? opaque * material->diffuse : material->diffuse;
  material->index_of_refraction = std::max<double>(1, from.ior);
  if (Sum(material->clear) > 0 && from.ior > kLargestIndex) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: Ni {} of glass is above {}; correct the line", material->where, from.ior,
                      kLargestIndex);
  }
  return {};
}

// -s scales and -o moves texture coordinates, whose v goes upwards here.
FileMap MapOf(const std::string& name, const tinyobj::texture_option_t& option,
              const std::string& path) {
  FileMap map;
  map.name = Trim(name);
  map.folder = FolderOf(path);
  const auto &scale = option.scale, &move = option.origin_offset;
  map.transform = {scale[0], 0, move[0], 0, scale[1], 1 - scale[1] - move[1]};
  if (option.clamp) map.wrap_u = map.wrap_v = Wrap::kClamp;
  return map;
}

// What Fl says, where that leaves no more than what arrives.
Result<Reradiation> ReradiationFrom(const FileMaterial& material, const Rgb& fl) {
  const Reradiation reradiation{fl.x, fl.y, fl.z};
  if (!reradiation.exists()) return Reradiation();
  // Of a map the texels are limited later.
  Rgb all = material.transmittance + reradiation.Taken();
  if (material.diffuse_map.name.empty()) all += material.diffuse;
  for (int c = 0; c < 3; ++c) {
    if (all[c] <= kMostLeaves) continue;
    constexpr const char* kChannels[] = {"red", "green", "blue"};
    return Error(StatusCode::kInvalidArgument,
                 "{}: material '{}' gives out {:.3g} of what arrives of {} by Kd, Td and Fl; lower "
                 "them to {} together",
                 material.where, material.name, all[c], kChannels[c], kMostLeaves);
  }
  return reradiation;
}

}  // namespace

Result<std::vector<FileMaterial>> ReadMtl(const std::string& path) {
  ASSIGN_OR_RETURN(std::string bytes, ReadFile(path, kMostMtlBytes));
  return ParseMtl(std::move(bytes), path);
}

Result<std::vector<FileMaterial>> ParseMtl(std::string bytes, const std::string& path) {
  ASSIGN_OR_RETURN(CleanText file, CleanText::FromBytes(std::move(bytes), path));
  ASSIGN_OR_RETURN(const std::vector<ScannedMaterial> scanned, Scan(file));
  std::map<std::string, int> numbers;
  std::vector<tinyobj::material_t> parsed;
  std::istringstream stream(std::move(file.text()));
  std::string warnings, errors;
  tinyobj::LoadMtl(&numbers, &parsed, &stream, &warnings, &errors);
  std::vector<FileMaterial> materials;
  for (size_t i = 0; i < scanned.size() && i < parsed.size(); ++i) {
    const tinyobj::material_t& from = parsed[i];
    FileMaterial material;
    material.name = Trim(from.name);
    material.where = fmt::format("{}:{}", path, scanned[i].line);
    material.diffuse_map = MapOf(from.diffuse_texname, from.diffuse_texopt, path);
    material.emission_map = MapOf(from.emissive_texname, from.emissive_texopt, path);
    material.diffuse = scanned[i].kd.value_or(Rgb(material.diffuse_map.name.empty() ? 0.0 : 1.0));
    material.radiance = scanned[i].ke.value_or(Rgb(material.emission_map.name.empty() ? 0.0 : 1.0));
    material.opacity_map = !from.alpha_texname.empty();
    material.transmittance = scanned[i].td.value_or(Rgb(0.0));
    ASSIGN_OR_RETURN(material.reradiation,
                     ReradiationFrom(material, scanned[i].fl.value_or(Rgb(0.0))));
    material.glass = IsGlass(from);
    if (material.glass) RETURN_IF_ERROR(SetGlass(scanned[i], from, &material));
    material.mirror = !material.glass && (from.illum == 3 || from.illum == 5 || from.illum == 8);
    if (material.mirror) material.specular = scanned[i].ks.value_or(Rgb(0.0));
    material.glossy = !material.glass && !material.mirror && Largest(from.specular) > 0;
    if (material.glossy) material.lobe = scanned[i].ks.value_or(Rgb(0.0));
    materials.push_back(std::move(material));
  }
  return materials;
}

}  // namespace isolux
