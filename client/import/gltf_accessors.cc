#include "client/import/gltf_accessors.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isolux {
namespace {

template <typename T>
double Load(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

size_t SizeOf(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

bool IsUnsigned(int component_type) {
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// A component as a number; integers that are normalised stand for [0, 1] or [-1, 1] (glTF 2.0,
// section 3.11).
double Decode(const uint8_t* bytes, int component_type, bool normalized) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return normalized ? std::max(Load<int8_t>(bytes) / 127, -1.0) : Load<int8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return Load<uint8_t>(bytes) / (normalized ? 255 : 1);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return normalized ? std::max(Load<int16_t>(bytes) / 32767, -1.0) : Load<int16_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return Load<uint16_t>(bytes) / (normalized ? 65535 : 1);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return Load<uint32_t>(bytes);
    default:
      return Load<float>(bytes);
  }
}

// Elements of one type, one after the other in a buffer view.
struct Elements {
  std::span<const uint8_t> bytes;
  uint64_t stride = 0;
  int component_type = 0;
  bool normalized = false;

  double Get(uint64_t element, size_t component) const {
    return Decode(bytes.data() + element * stride + component * SizeOf(component_type),
                  component_type, normalized);
  }
};

// Reads accessors of one document; errors name the accessor.
class AccessorReader {
 public:
  AccessorReader(const GltfDocument& document, int number)
      : document_(document), number_(number), element_(fmt::format("accessors[{}]", number)) {}

  // All components of all elements in turn.
  Result<std::vector<double>> Read(int type, uint64_t most);
  const std::string& element() const { return element_; }
  int component_type() const { return document_.model.accessors[number_].componentType; }
  bool normalized() const { return document_.model.accessors[number_].normalized; }
  Status Check() const;

 private:
  Result<Elements> View(int view, uint64_t offset, uint64_t count, int component_type,
                        size_t components) const;
  Status Replace(const tinygltf::Accessor& accessor, size_t components,
                 std::vector<double>* numbers) const;

  const GltfDocument& document_;
  int number_;
  std::string element_;
};

Status AccessorReader::Check() const {
  const size_t count = document_.model.accessors.size();
  if (number_ >= 0 && static_cast<size_t>(number_) < count) return {};
  return MakeStatus(StatusCode::kInvalidArgument,
                    "{}: {}: no such accessor, the file has {}; is the file whole?", document_.path,
                    element_, count);
}

Result<Elements> AccessorReader::View(int view, uint64_t offset, uint64_t count, int component_type,
                                      size_t components) const {
  ASSIGN_OR_RETURN(const std::span<const uint8_t> bytes, BytesOfView(document_, view));
  const uint64_t size = components * SizeOf(component_type);
  const uint64_t given = document_.model.bufferViews[view].byteStride;
  const uint64_t stride = given == 0 ? size : given;
  if (stride < size) {
    return document_.Error(StatusCode::kInvalidArgument, element_,
                           "elements of {} bytes do not fit the stride of {} in bufferViews[{}]; "
                           "export the file anew",
                           size, stride, view);
  }
  const uint64_t room = offset > bytes.size() ? 0 : bytes.size() - offset;
  // Divided, not multiplied: the numbers of a damaged file overflow.
  if (count > 0 && (room < size || count - 1 > (room - size) / stride)) {
    return document_.Error(StatusCode::kDataLoss, element_,
                           "{} elements from byte {} do not fit into the {} bytes of "
                           "bufferViews[{}]; is the file whole?",
                           count, offset, bytes.size(), view);
  }
  return Elements{count == 0 ? std::span<const uint8_t>() : bytes.subspan(offset), stride,
                  component_type, false};
}

Status AccessorReader::Replace(const tinygltf::Accessor& accessor, size_t components,
                               std::vector<double>* numbers) const {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || static_cast<uint64_t>(sparse.count) > accessor.count ||
      sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 ||
      !IsUnsigned(sparse.indices.componentType)) {
    return document_.Error(StatusCode::kInvalidArgument, element_ + ".sparse",
                           "count, byteOffset or componentType out of range; export the file anew");
  }
  const auto count = static_cast<uint64_t>(sparse.count);
  ASSIGN_OR_RETURN(const Elements indices,
                   View(sparse.indices.bufferView, sparse.indices.byteOffset, count,
                        sparse.indices.componentType, 1));
  ASSIGN_OR_RETURN(Elements values, View(sparse.values.bufferView, sparse.values.byteOffset, count,
                                         accessor.componentType, components));
  values.normalized = accessor.normalized;
  for (uint64_t i = 0; i < count; ++i) {
    const double at = indices.Get(i, 0);
    if (at >= static_cast<double>(accessor.count)) {
      return document_.Error(StatusCode::kInvalidArgument, element_ + ".sparse",
                             "index {} names element {}, there are {}; is the file whole?", i, at,
                             accessor.count);
    }
    for (size_t c = 0; c < components; ++c) {
      (*numbers)[static_cast<size_t>(at) * components + c] = values.Get(i, c);
    }
  }
  return {};
}

Result<std::vector<double>> AccessorReader::Read(int type, uint64_t most) {
  RETURN_IF_ERROR(Check());
  const tinygltf::Accessor& accessor = document_.model.accessors[number_];
  if (accessor.type != type || SizeOf(accessor.componentType) == 0) {
    return document_.Error(StatusCode::kInvalidArgument, element_,
                           "type or componentType does not suit its use; export the file anew");
  }
  if (accessor.count > most) {
    return document_.Error(StatusCode::kResourceExhausted, element_,
                           "{} elements, more than {}; simplify the scene", accessor.count, most);
  }
  const size_t components = type == TINYGLTF_TYPE_SCALAR ? 1 : static_cast<size_t>(type);
  Elements elements;
  if (accessor.bufferView >= 0) {
    ASSIGN_OR_RETURN(elements, View(accessor.bufferView, accessor.byteOffset, accessor.count,
                                    accessor.componentType, components));
    elements.normalized = accessor.normalized;
  }
  std::vector<double> numbers(accessor.count * components, 0.0);  // zero without a buffer view
  for (uint64_t i = 0; i < accessor.count && accessor.bufferView >= 0; ++i) {
    for (size_t c = 0; c < components; ++c) numbers[i * components + c] = elements.Get(i, c);
  }
  if (accessor.sparse.isSparse) RETURN_IF_ERROR(Replace(accessor, components, &numbers));
  return numbers;
}

}  // namespace

Result<std::span<const uint8_t>> BytesOfView(const GltfDocument& document, int view) {
  const tinygltf::Model& model = document.model;
  const std::string element = fmt::format("bufferViews[{}]", view);
  if (view < 0 || static_cast<size_t>(view) >= model.bufferViews.size()) {
    return document.Error(StatusCode::kInvalidArgument, element,
                          "no such buffer view, the file has {}; is the file whole?",
                          model.bufferViews.size());
  }
  const tinygltf::BufferView& from = model.bufferViews[view];
  if (from.buffer < 0 || static_cast<size_t>(from.buffer) >= model.buffers.size()) {
    return document.Error(StatusCode::kInvalidArgument, element,
                          "buffers[{}] does not exist, the file has {}; is the file whole?",
                          from.buffer, model.buffers.size());
  }
  const std::span<const uint8_t> bytes(model.buffers[from.buffer].data);
  if (from.byteOffset > bytes.size() || from.byteLength > bytes.size() - from.byteOffset) {
    return document.Error(StatusCode::kDataLoss, element,
                          "{} bytes from byte {} reach beyond the {} bytes of buffers[{}]; is the "
                          "file whole?",
                          from.byteLength, from.byteOffset, bytes.size(), from.buffer);
  }
  return bytes.subspan(from.byteOffset, from.byteLength);
}

Result<std::vector<Vec3>> ReadPoints(const GltfDocument& document, int accessor, uint64_t most) {
  AccessorReader reader(document, accessor);
  ASSIGN_OR_RETURN(const std::vector<double> numbers, reader.Read(TINYGLTF_TYPE_VEC3, most));
  std::vector<Vec3> points(numbers.size() / 3);
  for (size_t i = 0; i < points.size(); ++i) {
    points[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    if (std::isfinite(Sum(points[i]))) continue;
    return document.Error(StatusCode::kInvalidArgument, reader.element(),
                          "element {} ({} {} {}) is not a point; export the file anew", i,
                          points[i].x, points[i].y, points[i].z);
  }
  return points;
}

Result<std::vector<glm::dvec2>> ReadCoordinates(const GltfDocument& document, int accessor,
                                                uint64_t most) {
  AccessorReader reader(document, accessor);
  ASSIGN_OR_RETURN(const std::vector<double> numbers, reader.Read(TINYGLTF_TYPE_VEC2, most));
  std::vector<glm::dvec2> points(numbers.size() / 2);
  for (size_t i = 0; i < points.size(); ++i) points[i] = {numbers[2 * i], numbers[2 * i + 1]};
  return points;
}

Result<std::vector<uint32_t>> ReadIndices(const GltfDocument& document, int accessor,
                                          uint64_t most) {
  AccessorReader reader(document, accessor);
  RETURN_IF_ERROR(reader.Check());
  if (!IsUnsigned(reader.component_type()) || reader.normalized()) {
    return document.Error(StatusCode::kInvalidArgument, reader.element(),
                          "indices must be unsigned integers; export the file anew");
  }
  ASSIGN_OR_RETURN(const std::vector<double> numbers, reader.Read(TINYGLTF_TYPE_SCALAR, most));
  return std::vector<uint32_t>(numbers.begin(), numbers.end());
}

}  // namespace isolux
