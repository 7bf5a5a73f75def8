/* Mesh files in glTF and GLB, through tinygltf. The only file that holds tinygltf's code; Draco meshes are decoded here, with
 * checks that tinygltf's own Draco path lacks (it trusts attribute ids and indices of the file). */
#define TINYGLTF_IMPLEMENTATION
#include "support_file_gltf.h"

#ifdef SCREE_WITH_DRACO
#include <draco/compression/decode.h>
#endif

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "file.h"

namespace {

using fault = gltf_fault;

const size_t file_limit = size_t(1) << 30;
const uint32_t depth_limit = 64;
const size_t triangle_limit = size_t(1) << 26;

uint32_t word_at(const char* bytes) {
  const unsigned char* b = reinterpret_cast<const unsigned char*>(bytes);
  return uint32_t(b[0]) | uint32_t(b[1]) << 8 | uint32_t(b[2]) << 16 | uint32_t(b[3]) << 24;
}

/* tinygltf recurses over JSON; a hostile file must not choose how deep. */
void check_nesting(const char* text, size_t size) {
  size_t depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < size; ++i) {
    char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > 128) throw fault("JSON is nested too deeply");
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
}

/* The JSON as tinygltf shall see it: it refuses indices without a buffer view, which is what Draco meshes have, so theirs are moved
 * into the extension. */
std::string prepare(const char* text, size_t size) {
  check_nesting(text, size);
  nlohmann::json root = nlohmann::json::parse(text, text + size, nullptr, false);
  if (!root.is_object()) throw fault("not valid JSON");
  if (root.contains("meshes") && root["meshes"].is_array()) {
    for (nlohmann::json& mesh : root["meshes"]) {
      if (!mesh.is_object() || !mesh.contains("primitives") || !mesh["primitives"].is_array()) continue;
      for (nlohmann::json& primitive : mesh["primitives"]) {
        bool has_draco = primitive.is_object() && primitive.contains("extensions") && primitive["extensions"].is_object() &&
                         primitive["extensions"].contains("KHR_draco_mesh_compression");
        if (!has_draco || !primitive.contains("indices")) continue;
        primitive["extensions"]["KHR_draco_mesh_compression"]["indices"] = primitive["indices"];
        primitive.erase("indices");
      }
    }
  }
  return root.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void add_word(std::string& out, size_t word) {
  for (int i = 0; i < 4; ++i) out.push_back(char(word >> (8 * i) & 255));
}

/* A GLB file with its JSON prepared. (tinygltf 2.7 lets a BIN chunk reach 8 bytes past the end of the file; not here.) */
std::string prepare_binary(const char* bytes, size_t size) {
  if (size < 20 || word_at(bytes + 4) != 2 || word_at(bytes + 16) != 0x4e4f534a) throw fault("not a GLB file of version 2");
  size_t length = word_at(bytes + 8);
  if (length > size) throw fault("the file is truncated");
  size_t text = word_at(bytes + 12);
  if (length < 20 || text > length - 20) throw fault("the JSON chunk reaches past the end of the file");
  std::string prepared = prepare(bytes + 20, text);
  prepared.resize((prepared.size() + 3) & ~size_t(3), ' ');
  size_t rest = length - 20 - text;
  if (rest > 0 && (rest < 8 || word_at(bytes + 20 + text) > rest - 8))
    throw fault("the BIN chunk reaches past the end of the file");
  if (20 + prepared.size() + rest > UINT32_MAX) throw fault("the file is too large");
  std::string out;
  out.reserve(20 + prepared.size() + rest);
  out.append(bytes, 8);
  add_word(out, 20 + prepared.size() + rest);
  add_word(out, prepared.size());
  out.append(bytes + 16, 4);
  out += prepared;
  out.append(bytes + 20 + text, rest);
  return out;
}

bool exists(const std::string& name, void*) {
  return file_exists(name.c_str());
}
std::string expand(const std::string& name, void*) {
  return name;
}
bool write(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}

bool read(std::vector<unsigned char>* out, std::string* message, const std::string& name, void*) {
  char* bytes;
  size_t size;
  scree_error error;
  if (file_read(name.c_str(), file_limit, &bytes, &size, &error) != SCREE_OK) {
    *message += error.message;
    return false;
  }
  out->assign(bytes, bytes + size);
  free(bytes);
  return true;
}

bool ignore_image(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

/* element i of a vector of the model, checked. */
template <typename T>
const T& at(const std::vector<T>& items, int i, const char* what) {
  if (i < 0 || size_t(i) >= items.size())
    throw fault(std::string("names the ") + what + " " + std::to_string(i) + ", which does not exist");
  return items[size_t(i)];
}

struct view {
  const unsigned char* bytes;
  size_t size, stride;
};

view view_of(const tinygltf::Model& model, int index) {
  const tinygltf::BufferView& v = at(model.bufferViews, index, "buffer view");
  const tinygltf::Buffer& buffer = at(model.buffers, v.buffer, "buffer");
  if (v.byteOffset > buffer.data.size() || v.byteLength > buffer.data.size() - v.byteOffset)
    throw fault("a buffer view reaches past the end of its buffer");
  return {buffer.data.data() + v.byteOffset, v.byteLength, v.byteStride};
}

/* Where the elements of an accessor lie, after checking that all of them do. */
const unsigned char* elements(const tinygltf::Model& model, const tinygltf::Accessor& accessor, size_t element, size_t* stride) {
  if (accessor.sparse.isSparse) throw fault("sparse accessors are not read");
  view v = view_of(model, accessor.bufferView);
  *stride = v.stride != 0 ? v.stride : element;
  if (accessor.count == 0) return v.bytes;
  if (accessor.byteOffset > v.size || element > v.size - accessor.byteOffset ||
      (accessor.count - 1) > (v.size - accessor.byteOffset - element) / *stride)
    throw fault("an accessor reaches past the end of its buffer view");
  return v.bytes + accessor.byteOffset;
}

struct soup {
  std::vector<float> positions;
  std::vector<float> normals;     /* as many as positions, or none: then they are those of the triangles */
  std::vector<float> colours;     /* linear RGB, as many as positions, or none: white */
  std::vector<float> coordinates; /* u, v of each vertex of a part, or none */
  std::vector<float> uvs;         /* u, v of each corner of the whole; fewer where a part has none */
  std::vector<uint32_t> indices;

  uint32_t vertex_count() const { return uint32_t(positions.size() / 3); }
};

/* Up to three components of one element of an accessor as numbers; integers are normalised. */
bool is_numbers(const tinygltf::Accessor& accessor) {
  return (accessor.type == TINYGLTF_TYPE_VEC3 || accessor.type == TINYGLTF_TYPE_VEC4) &&
         (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT ||
          accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
          accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
}

/* An attribute of vectors that may be missing: empty then. */
std::vector<float> read_vectors(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const char* name,
                                size_t count) {
  auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return {};
  const tinygltf::Accessor& accessor = at(model.accessors, found->second, "accessor");
  if (!is_numbers(accessor)) throw fault(std::string(name) + " is of a type that is not read");
  if (accessor.count != count) throw fault(std::string(name) + " has not one element a vertex");
  const size_t component = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT            ? 4
                           : accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2
                                                                                              : 1;
  size_t stride;
  const unsigned char* bytes = elements(model, accessor, component * (accessor.type == TINYGLTF_TYPE_VEC3 ? 3 : 4), &stride);
  std::vector<float> out(count * 3);
  for (size_t i = 0; i < out.size(); ++i) {
    const unsigned char* from = bytes + i / 3 * stride + i % 3 * component;
    if (component == 4)
      std::memcpy(&out[i], from, 4);
    else
      out[i] = component == 2 ? float(from[0] | from[1] << 8) / 65535.0f : float(from[0]) / 255.0f;
    if (!std::isfinite(out[i])) throw fault(std::string(name) + " is not finite");
  }
  return out;
}

/* TEXCOORD_0, which may be missing: empty then. */
std::vector<float> read_coordinates(const tinygltf::Model& model, const tinygltf::Primitive& primitive, size_t count) {
  auto found = primitive.attributes.find("TEXCOORD_0");
  if (found == primitive.attributes.end()) return {};
  const tinygltf::Accessor& accessor = at(model.accessors, found->second, "accessor");
  const bool real = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
  const bool wide = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  if (accessor.type != TINYGLTF_TYPE_VEC2 ||
      !(real || (accessor.normalized && (wide || accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE))))
    throw fault("TEXCOORD_0 is of a type that is not read");
  if (accessor.count != count) throw fault("TEXCOORD_0 has not one element a vertex");
  const size_t component = real ? 4 : wide ? 2 : 1;
  size_t stride;
  const unsigned char* bytes = elements(model, accessor, 2 * component, &stride);
  std::vector<float> out(count * 2);
  for (size_t i = 0; i < out.size(); ++i) {
    const unsigned char* from = bytes + i / 2 * stride + i % 2 * component;
    if (real)
      std::memcpy(&out[i], from, 4);
    else
      out[i] = wide ? float(from[0] | from[1] << 8) / 65535.0f : float(from[0]) / 255.0f;
    if (!std::isfinite(out[i])) throw fault("TEXCOORD_0 is not finite");
  }
  return out;
}

/* painted: normals and colours are wanted, but no UVs. */
void read_plain(const tinygltf::Model& model, const tinygltf::Primitive& primitive, bool painted, soup& out) {
  auto found = primitive.attributes.find("POSITION");
  if (found == primitive.attributes.end()) throw fault("a mesh has no POSITION");
  const tinygltf::Accessor& place = at(model.accessors, found->second, "accessor");
  if (place.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT || place.type != TINYGLTF_TYPE_VEC3)
    throw fault("only float POSITION is read");
  size_t stride;
  const unsigned char* bytes = elements(model, place, 12, &stride);
  out.positions.resize(place.count * 3);
  for (size_t i = 0; i < place.count; ++i) std::memcpy(&out.positions[i * 3], bytes + i * stride, 12);
  if (painted) {
    out.normals = read_vectors(model, primitive, "NORMAL", place.count);
    out.colours = read_vectors(model, primitive, "COLOR_0", place.count);
  } else {
    out.coordinates = read_coordinates(model, primitive, place.count);
  }
  if (primitive.indices < 0) {
    for (uint32_t i = 0; i < place.count; ++i) out.indices.push_back(i);
    return;
  }
  const tinygltf::Accessor& list = at(model.accessors, primitive.indices, "accessor");
  if (list.type != TINYGLTF_TYPE_SCALAR) throw fault("indices are not scalars");
  size_t size;
  switch (list.componentType) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: size = 1; break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: size = 2; break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: size = 4; break;
    default: throw fault("indices are not unsigned integers");
  }
  bytes = elements(model, list, size, &stride);
  out.indices.resize(list.count);
  for (size_t i = 0; i < list.count; ++i) {
    uint32_t index = 0;
    for (size_t k = 0; k < size; ++k) index |= uint32_t(bytes[i * stride + k]) << (8 * k);
    out.indices[i] = index;
  }
}

#ifdef SCREE_WITH_DRACO
void read_draco(const tinygltf::Model& model, const tinygltf::Value& extension, bool painted, soup& out) {
  if (!extension.IsObject()) throw fault("KHR_draco_mesh_compression is not an object");
  const tinygltf::Value& attributes = extension.Get("attributes");
  const tinygltf::Value& buffer_view = extension.Get("bufferView");
  if (!attributes.IsObject() || !attributes.Get("POSITION").IsInt() || !buffer_view.IsInt())
    throw fault("KHR_draco_mesh_compression names no POSITION");
  view v = view_of(model, buffer_view.Get<int>());
  draco::DecoderBuffer bytes;
  bytes.Init(reinterpret_cast<const char*>(v.bytes), v.size);
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&bytes);
  if (!decoded.ok()) throw fault(std::string("Draco: ") + decoded.status().error_msg());
  const draco::Mesh& mesh = *decoded.value();
  int id = attributes.Get("POSITION").Get<int>();
  const draco::PointAttribute* place = id >= 0 ? mesh.GetAttributeByUniqueId(uint32_t(id)) : nullptr;
  if (place == nullptr || place->num_components() != 3) throw fault("Draco: no such POSITION");
  out.positions.resize(size_t(mesh.num_points()) * 3);
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
    if (!place->ConvertValue<float>(place->mapped_index(i), 3, &out.positions[size_t(i.value()) * 3]))
      throw fault("Draco: broken POSITION");
  }
  static const char* const names[] = {"NORMAL", "COLOR_0"};
  for (const char* name : names) {
    if (!painted || !attributes.Has(name) || !attributes.Get(name).IsInt()) continue;
    const int own = attributes.Get(name).Get<int>();
    const draco::PointAttribute* vectors = own >= 0 ? mesh.GetAttributeByUniqueId(uint32_t(own)) : nullptr;
    if (vectors == nullptr || vectors->num_components() < 3 || vectors->num_components() > 4)
      throw fault(std::string("Draco: no such ") + name);
    std::vector<float>& to = name == names[0] ? out.normals : out.colours;
    to.resize(size_t(mesh.num_points()) * 3);
    for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
      float value[4] = {0, 0, 0, 0};
      if (!vectors->ConvertValue<float>(vectors->mapped_index(i), vectors->num_components(), value))
        throw fault(std::string("Draco: broken ") + name);
      std::memcpy(&to[size_t(i.value()) * 3], value, 12);
    }
  }
  if (!painted && attributes.Has("TEXCOORD_0") && attributes.Get("TEXCOORD_0").IsInt()) {
    const int own = attributes.Get("TEXCOORD_0").Get<int>();
    const draco::PointAttribute* pairs = own >= 0 ? mesh.GetAttributeByUniqueId(uint32_t(own)) : nullptr;
    if (pairs == nullptr || pairs->num_components() != 2) throw fault("Draco: no such TEXCOORD_0");
    const bool wide = pairs->data_type() == draco::DT_UINT16;
    if (!wide && pairs->data_type() != draco::DT_UINT8 && pairs->data_type() != draco::DT_FLOAT32)
      throw fault("TEXCOORD_0 is of a type that is not read");
    /* The accessor's integers are normalised even where Draco's do not say so. */
    const bool as_is = pairs->data_type() == draco::DT_FLOAT32 || pairs->normalized();
    const float whole = as_is ? 1.0f : wide ? 65535.0f : 255.0f;
    out.coordinates.resize(size_t(mesh.num_points()) * 2);
    for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
      float* to = &out.coordinates[size_t(i.value()) * 2];
      if (!pairs->ConvertValue<float>(pairs->mapped_index(i), 2, to)) throw fault("Draco: broken TEXCOORD_0");
      if (!std::isfinite(to[0]) || !std::isfinite(to[1])) throw fault("TEXCOORD_0 is not finite");
      to[0] /= whole, to[1] /= whole;
    }
  }
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
    for (size_t k = 0; k < 3; ++k) out.indices.push_back(mesh.face(f)[k].value());
  }
}

#else
void read_draco(const tinygltf::Model&, const tinygltf::Value&, bool, soup&) {
  throw fault("holds Draco meshes, and this build has no Draco");
}
#endif

/* Column-major, as in glTF. */
struct matrix {
  double m[16];

  static matrix identity() { return {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}; }

  matrix operator*(const matrix& b) const {
    matrix r{};
    for (size_t column = 0; column < 4; ++column) {
      for (size_t row = 0; row < 4; ++row) {
        for (size_t k = 0; k < 4; ++k) r.m[column * 4 + row] += m[k * 4 + row] * b.m[column * 4 + k];
      }
    }
    return r;
  }

  double determinant() const {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5]);
  }
};

matrix matrix_of(const tinygltf::Node& node) {
  matrix r = matrix::identity();
  if (node.matrix.size() == 16) {
    for (size_t i = 0; i < 16; ++i) r.m[i] = node.matrix[i];
    return r;
  }
  if (node.rotation.size() == 4) {
    double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
    r.m[0] = 1 - 2 * (y * y + z * z), r.m[4] = 2 * (x * y - z * w), r.m[8] = 2 * (x * z + y * w);
    r.m[1] = 2 * (x * y + z * w), r.m[5] = 1 - 2 * (x * x + z * z), r.m[9] = 2 * (y * z - x * w);
    r.m[2] = 2 * (x * z - y * w), r.m[6] = 2 * (y * z + x * w), r.m[10] = 1 - 2 * (x * x + y * y);
  }
  for (size_t column = 0; column < 3 && node.scale.size() == 3; ++column) {
    for (size_t row = 0; row < 3; ++row) r.m[column * 4 + row] *= node.scale[column];
  }
  for (size_t row = 0; row < 3 && node.translation.size() == 3; ++row) r.m[12 + row] = node.translation[row];
  return r;
}

/* Gives every triangle vertices of its own with its own normal, as the specification says of meshes without normals. */
void flatten(soup& part) {
  soup flat;
  for (size_t i = 0; i + 2 < part.indices.size(); i += 3) {
    const float* p[3];
    for (size_t k = 0; k < 3; ++k) {
      if (part.indices[i + k] >= part.vertex_count()) throw fault("an index points past the last vertex");
      p[k] = &part.positions[size_t(part.indices[i + k]) * 3];
    }
    const float u[3] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
    const float v[3] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
    const float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    for (size_t k = 0; k < 3; ++k) {
      flat.indices.push_back(uint32_t(flat.indices.size()));
      flat.positions.insert(flat.positions.end(), p[k], p[k] + 3);
      flat.normals.insert(flat.normals.end(), n, n + 3);
      if (part.colours.empty()) continue;
      const float* colour = &part.colours[size_t(part.indices[i + k]) * 3];
      flat.colours.insert(flat.colours.end(), colour, colour + 3);
    }
  }
  part = std::move(flat);
}

/* Normals go with the cofactors of the matrix, so that they stay at right angles; made unit, pointing up where there is none. */
void append_normals(const soup& part, const matrix& to_world, soup& out) {
  const double* m = to_world.m;
  const double sign = to_world.determinant() < 0 ? -1 : 1;
  double c[9];
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) {
      const size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      c[i * 3 + k] = sign * (m[i1 * 4 + k1] * m[i2 * 4 + k2] - m[i1 * 4 + k2] * m[i2 * 4 + k1]);
    }
  for (size_t i = 0; i < part.normals.size(); i += 3) {
    const float* n = &part.normals[i];
    double v[3], squared = 0;
    for (size_t row = 0; row < 3; ++row) {
      v[row] = c[row] * double(n[0]) + c[3 + row] * double(n[1]) + c[6 + row] * double(n[2]);
      squared += v[row] * v[row];
    }
    const double length = std::sqrt(squared);
    for (size_t row = 0; row < 3; ++row) out.normals.push_back(length > 0 ? float(v[row] / length) : row == 1 ? 1.0f : 0.0f);
  }
}

void append(const soup& part, const matrix& to_world, soup& out) {
  uint32_t base = out.vertex_count(), count = part.vertex_count();
  if (out.indices.size() + part.indices.size() > triangle_limit * 3 || size_t(base) + count > UINT32_MAX / 4)
    throw fault("has too many triangles");
  const double* m = to_world.m;
  for (size_t i = 0; i < count; ++i) {
    const float* p = &part.positions[i * 3];
    for (size_t row = 0; row < 3; ++row) {
      double value = m[row] * double(p[0]) + m[4 + row] * double(p[1]) + m[8 + row] * double(p[2]) + m[12 + row];
      if (!std::isfinite(value) || std::fabs(value) > 1e12) throw fault("a position is not finite");
      out.positions.push_back(float(value));
    }
  }
  /* A mirroring transform turns triangles inside out; the specification says to turn them back. */
  size_t second = to_world.determinant() < 0 ? 2 : 1;
  for (size_t i = 0; i + 2 < part.indices.size(); i += 3) {
    for (size_t k = 0; k < 3; ++k) {
      uint32_t index = part.indices[i + (k == 0 ? 0 : k == 1 ? second : 3 - second)];
      if (index >= count) throw fault("an index points past the last vertex");
      out.indices.push_back(base + index);
      if (part.coordinates.empty()) continue;
      out.uvs.push_back(part.coordinates[size_t(index) * 2]);
      out.uvs.push_back(part.coordinates[size_t(index) * 2 + 1]);
    }
  }
}

/* The colour of a material, or what glTF says of things without one. */
void append_colours(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const soup& part, soup& out) {
  double base[3] = {1, 1, 1};
  if (primitive.material >= 0) {
    const tinygltf::Material& material = at(model.materials, primitive.material, "material");
    const std::vector<double>& factor = material.pbrMetallicRoughness.baseColorFactor;
    for (size_t k = 0; k < 3 && factor.size() == 4; ++k) base[k] = factor[k];
  }
  for (size_t i = 0; i < size_t(part.vertex_count()) * 3; ++i)
    out.colours.push_back(float(base[i % 3] * (part.colours.empty() ? 1.0 : double(part.colours[i]))));
}

void add_mesh(const tinygltf::Model& model, const tinygltf::Mesh& mesh, const matrix& to_world, bool painted, soup& out) {
  for (const tinygltf::Primitive& primitive : mesh.primitives) {
    bool is_line = primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode <= TINYGLTF_MODE_LINE_STRIP;
    if (is_line) continue;
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES) throw fault("only lists of triangles are read, no strips and fans");
    soup part;
    auto draco_extension = primitive.extensions.find("KHR_draco_mesh_compression");
    if (draco_extension != primitive.extensions.end()) {
      read_draco(model, draco_extension->second, painted, part);
    } else {
      read_plain(model, primitive, painted, part);
    }
    if (painted) {
      if (part.normals.empty()) flatten(part);
      append_normals(part, to_world, out);
      append_colours(model, primitive, part, out);
    }
    append(part, to_world, out);
  }
}

/* `visits` bounds the walk: a hostile file may reach a node along many paths. */
void add_node(const tinygltf::Model& model, int index, const matrix& parent, uint32_t depth, bool painted, size_t& visits,
              soup& out) {
  const tinygltf::Node& node = at(model.nodes, index, "node");
  if (depth >= depth_limit || ++visits > model.nodes.size()) throw fault("nodes form a loop, or are nested too deeply");
  matrix to_world = parent * matrix_of(node);
  if (node.mesh >= 0) add_mesh(model, at(model.meshes, node.mesh, "mesh"), to_world, painted, out);
  for (int child : node.children) add_node(model, child, to_world, depth + 1, painted, visits, out);
}

void add_scene(const tinygltf::Model& model, bool painted, soup& out) {
  if (model.scenes.empty()) throw fault("has no scene");
  const tinygltf::Scene& scene = at(model.scenes, model.defaultScene >= 0 ? model.defaultScene : 0, "scene");
  size_t visits = 0;
  for (int node : scene.nodes) add_node(model, node, matrix::identity(), 0, painted, visits, out);
}

/* A file may demand extensions; those that change nothing about shapes are welcome. */
void check_extensions(const tinygltf::Model& model) {
  for (const std::string& name : model.extensionsRequired) {
    bool harmless = name.rfind("KHR_materials_", 0) == 0 || name.rfind("KHR_texture_", 0) == 0 ||
                    name.rfind("EXT_texture_", 0) == 0 || name == "KHR_lights_punctual";
    if (!harmless && name != "KHR_draco_mesh_compression") throw fault("needs the extension " + name + ", which is not read");
  }
}

std::string folder_of(const char* file) {
  const char* slash = std::strrchr(file, '/');
  return slash == nullptr ? std::string() : std::string(file, size_t(slash - file));
}

template <typename T>
T* copy_of(const std::vector<T>& items) {
  T* copy = static_cast<T*>(std::malloc(items.size() * sizeof(T)));
  if (copy != nullptr) std::memcpy(copy, items.data(), items.size() * sizeof(T));
  return copy;
}

}  // namespace

void gltf_load(const char* bytes, size_t size, const char* file, tinygltf::Model& model) {
  if (size >= UINT32_MAX) throw fault("the file is too large");
  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks({exists, expand, read, write, nullptr});
  loader.SetImageLoader(ignore_image, nullptr);
  std::string message, warning;
  const bool is_binary = size >= 4 && std::memcmp(bytes, "glTF", 4) == 0;
  const std::string prepared = is_binary ? prepare_binary(bytes, size) : prepare(bytes, size);
  const unsigned length = unsigned(prepared.size());
  const bool good =
      is_binary ? loader.LoadBinaryFromMemory(&model, &message, &warning, reinterpret_cast<const unsigned char*>(prepared.data()),
                                              length, folder_of(file))
                : loader.LoadASCIIFromString(&model, &message, &warning, prepared.data(), length, folder_of(file));
  if (!good) throw fault(message.empty() ? "not a glTF file" : message.substr(0, message.find('\n')));
}

/* Everything that both readers do; *out is whole or empty. */
static scree_result read_soup(const char* bytes, size_t size, const char* file, bool painted, soup& all, scree_error* error) {
  try {
    tinygltf::Model model;
    gltf_load(bytes, size, file, model);
    check_extensions(model);
    add_scene(model, painted, all);
    if (all.indices.empty()) throw fault("has no triangles");
    return SCREE_OK;
  } catch (const fault& e) {
    return fail_with(error, SCREE_ERROR_SYNTAX, "%s: %s", file, e.what());
  } catch (const std::bad_alloc&) {
  } catch (const std::length_error&) {
  } catch (const std::exception& e) {
    return fail_with(error, SCREE_ERROR_SYNTAX, "%s: %s", file, e.what());
  }
  return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file);
}

extern "C" scree_result mesh_read_gltf(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error) {
  *out = triangle_mesh{};
  soup all;
  scree_result result = read_soup(bytes, size, file, false, all, error);
  if (result != SCREE_OK) return result;
  out->positions = copy_of(all.positions);
  out->indices = copy_of(all.indices);
  const bool whole = all.uvs.size() == all.indices.size() * 2; /* no part is without */
  if (whole) out->uvs = copy_of(all.uvs);
  out->vertex_count = all.vertex_count();
  out->triangle_count = uint32_t(all.indices.size() / 3);
  if (out->positions != nullptr && out->indices != nullptr && (out->uvs != nullptr || !whole)) return SCREE_OK;
  triangle_mesh_free(out);
  return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file);
}

extern "C" scree_result model_read_gltf(const char* bytes, size_t size, const char* file, painted_mesh* out, scree_error* error) {
  *out = painted_mesh{};
  soup all;
  scree_result result = read_soup(bytes, size, file, true, all, error);
  if (result != SCREE_OK) return result;
  out->positions = copy_of(all.positions);
  out->normals = copy_of(all.normals);
  out->colours = copy_of(all.colours);
  out->indices = copy_of(all.indices);
  out->vertex_count = all.vertex_count();
  out->triangle_count = uint32_t(all.indices.size() / 3);
  if (out->positions != nullptr && out->normals != nullptr && out->colours != nullptr && out->indices != nullptr) return SCREE_OK;
  painted_mesh_free(out);
  return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file);
}
