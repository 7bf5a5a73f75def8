// The only file of the runtime that sees Draco, and the only one in C++. Everything it hears from a blob is checked against the
// record of the pack before anything is written.
#include "draco_decode.h"

#include <draco/compression/decode.h>

#include <cstring>
#include <memory>
#include <new>
#include <vector>

#include "mesh_normals.h"
#include "occlusion.h"
#include "pack_internal.h"
#include "surface_bytes.h"

namespace {

// The one attribute of rocks: POSITION of four int16 without gaps, x, y, z and the occlusion's level. One attribute instead of two
// saves Draco a pass over the mesh, an entropy table and 3 % of the bytes.
const draco::PointAttribute* vertex_attribute(const draco::Mesh& mesh) {
  const draco::PointAttribute* attribute = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (attribute == nullptr || attribute->data_type() != draco::DT_INT16 || attribute->num_components() != 4) return nullptr;
  if (attribute->byte_stride() != 4 * sizeof(int16_t) || attribute->byte_offset() != 0) return nullptr;
  if (attribute->buffer()->data_size() / (4 * sizeof(int16_t)) < attribute->size()) return nullptr;
  return attribute;
}

// An attribute without gaps, or null. What models have beside positions is GENERIC, and what cliffs have besides is TEX_COORD.
const draco::PointAttribute* other_attribute(const draco::Mesh& mesh, draco::GeometryAttribute::Type kind, draco::DataType type,
                                             int components) {
  const draco::PointAttribute* attribute = mesh.GetNamedAttribute(kind);
  if (attribute == nullptr || attribute->data_type() != type || attribute->num_components() != components) return nullptr;
  const int64_t stride = int64_t{components} * draco::DataTypeLength(type);
  if (attribute->byte_stride() != stride || attribute->byte_offset() != 0) return nullptr;
  if (attribute->buffer()->data_size() / static_cast<size_t>(stride) < attribute->size()) return nullptr;
  return attribute;
}

const draco::PointAttribute* surface_attribute(const draco::Mesh& mesh) {
  return other_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 4);
}

const draco::PointAttribute* uv_attribute(const draco::Mesh& mesh) {
  return other_attribute(mesh, draco::GeometryAttribute::TEX_COORD, draco::DT_UINT16, 2);
}

// The bytes of a vertex, each `size` long; null where it has none.
const uint8_t* value_of(const draco::PointAttribute& attribute, uint32_t vertex, size_t size) {
  if (attribute.is_mapping_identity() && attribute.size() <= vertex) return nullptr;
  const uint32_t index = attribute.mapped_index(draco::PointIndex(vertex)).value();
  return index < attribute.size() ? attribute.buffer()->data() + size_t{index} * size : nullptr;
}

// Adds what the surface of a model has. Returns false when a vertex has no value, or one that cannot be.
bool copy_surface(const draco::PointAttribute& attribute, bool cliff, uint32_t vertex_count, scree_vertex* vertices) {
  for (uint32_t i = 0; i < vertex_count; ++i) {
    const uint8_t* value = value_of(attribute, i, 4);
    if (value == nullptr || !scree_rt_surface_is_sound(value, cliff)) return false;
    scree_rt_surface_decode(value, &vertices[i]);
  }
  return true;
}

// Writes position and occlusion of every vertex. Returns false when a vertex has no value.
bool copy_vertices(const draco::PointAttribute& attribute, uint32_t vertex_count, scree_vertex* vertices) {
  const uint8_t* values = attribute.buffer()->data();
  if (attribute.is_mapping_identity() && attribute.size() < vertex_count) return false;
  for (uint32_t i = 0; i < vertex_count; ++i) {
    const uint32_t index = attribute.mapped_index(draco::PointIndex(i)).value();
    if (index >= attribute.size()) return false;
    int16_t value[4];
    std::memcpy(value, values + size_t{index} * sizeof value, sizeof value);
    scree_vertex vertex = {};
    std::memcpy(vertex.position, value, sizeof vertex.position);
    vertex.occlusion = occlusion_value(value[3]);
    vertices[i] = vertex;
  }
  return true;
}

// Draco keeps triangles as arrays of three structs of one uint32_t, one behind the other.
const uint32_t* triangle_indices(const draco::Mesh& mesh) {
  static_assert(sizeof(draco::Mesh::Face) == 3 * sizeof(uint32_t), "a face is three indices");
  return reinterpret_cast<const uint32_t*>(&mesh.face(draco::FaceIndex(0)));
}

bool indices_are_below(const uint32_t* indices, size_t count, uint32_t limit) {
  uint32_t greatest = 0;
  for (size_t i = 0; i < count; ++i) greatest = indices[i] > greatest ? indices[i] : greatest;
  return greatest < limit;
}

bool read_varint(const uint8_t** at, const uint8_t* end, uint32_t* value) {
  *value = 0;
  for (uint32_t shift = 0; shift < 32 && *at < end; shift += 7) {
    const uint8_t byte = *(*at)++;
    *value |= uint32_t{byte & 0x7fu} << shift;
    if (byte < 0x80) return shift < 28 || byte < 0x10;
  }
  return false;
}

// Whether a blob says of itself that it is an edgebreaker mesh of bitstream 2.2 and of the size that the record has. libdraco takes
// memory for as many triangles as a blob claims before it finds out that they are not there.
bool head_matches(const uint8_t* blob, size_t blob_size, uint32_t triangle_count) {
  static const uint8_t expected[] = {'D', 'R', 'A', 'C', 'O', 2, 2, draco::TRIANGULAR_MESH, draco::MESH_EDGEBREAKER_ENCODING, 0, 0};
  if (blob_size <= sizeof expected || std::memcmp(blob, expected, sizeof expected) != 0) return false;
  const uint8_t* at = blob + sizeof expected + 1;  // the kind of edgebreaker
  const uint8_t* end = blob + blob_size;
  uint32_t vertices = 0, faces = 0;
  if (!read_varint(&at, end, &vertices) || !read_varint(&at, end, &faces)) return false;
  return faces == triangle_count && vertices <= 3 * uint64_t{triangle_count};
}

// Decodes into a mesh of just these numbers of vertices and triangles, with the attributes that blobs of packs of this kind have.
scree_result decode_mesh(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                         scree_pack_kind kind, draco::Mesh* mesh) {
  if (!head_matches(blob, blob_size, triangle_count)) return SCREE_ERROR_CORRUPT;
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(blob), blob_size);
  draco::Decoder decoder;
  if (!decoder.DecodeBufferToGeometry(&buffer, mesh).ok()) return SCREE_ERROR_CORRUPT;
  if (mesh->num_points() != vertex_count || mesh->num_faces() != triangle_count) return SCREE_ERROR_CORRUPT;
  if (vertex_attribute(*mesh) == nullptr) return SCREE_ERROR_CORRUPT;
  if (kind != SCREE_PACK_TILES && surface_attribute(*mesh) == nullptr) return SCREE_ERROR_CORRUPT;
  return kind != SCREE_PACK_CLIFF || uv_attribute(*mesh) != nullptr ? SCREE_OK : SCREE_ERROR_CORRUPT;
}

scree_result decode(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count, scree_pack_kind kind,
                    scree_vertex* vertices, void* indices, uint32_t index_size) {
  draco::Mesh mesh;
  const scree_result result = decode_mesh(blob, blob_size, vertex_count, triangle_count, kind, &mesh);
  if (result != SCREE_OK) return result;
  const size_t index_count = 3 * size_t{triangle_count};
  const uint32_t* decoded = triangle_indices(mesh);
  if (!indices_are_below(decoded, index_count, vertex_count)) return SCREE_ERROR_CORRUPT;
  if (!copy_vertices(*vertex_attribute(mesh), vertex_count, vertices)) return SCREE_ERROR_CORRUPT;
  if (kind != SCREE_PACK_TILES && !copy_surface(*surface_attribute(mesh), kind == SCREE_PACK_CLIFF, vertex_count, vertices))
    return SCREE_ERROR_CORRUPT;
  if (kind == SCREE_PACK_CLIFF) {
    std::vector<uint8_t> groups(vertex_count);
    const auto& surface = *surface_attribute(mesh);
    for (uint32_t i = 0; i < vertex_count; ++i) groups[i] = value_of(surface, i, 4)[3];
    const std::unique_ptr<char[]> scratch(new char[scree_rt_joined_normals_scratch(vertex_count)]);
    scree_rt_joined_normals(vertices, groups.data(), vertex_count, decoded, triangle_count, scratch.get());
  } else {
    const std::unique_ptr<char[]> scratch(new char[size_t{vertex_count} * MESH_NORMALS_SCRATCH]);
    scree_rt_mesh_normals(vertices, vertex_count, decoded, triangle_count, scratch.get());
  }

  if (index_size == sizeof(uint32_t)) {
    std::memcpy(indices, decoded, index_count * sizeof(uint32_t));
  } else {
    uint16_t* narrow = static_cast<uint16_t*>(indices);
    for (size_t i = 0; i < index_count; ++i) narrow[i] = static_cast<uint16_t>(decoded[i]);
  }
  return SCREE_OK;
}

scree_result decode_uvs(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count, scree_uv* uvs,
                        uint8_t* groups) {
  draco::Mesh mesh;
  const scree_result result = decode_mesh(blob, blob_size, vertex_count, triangle_count, SCREE_PACK_CLIFF, &mesh);
  if (result != SCREE_OK) return result;
  const auto &all_uvs = *uv_attribute(mesh), &surfaces = *surface_attribute(mesh);
  for (uint32_t i = 0; i < vertex_count; ++i) {
    const uint8_t* uv = value_of(all_uvs, i, sizeof *uvs);
    const uint8_t* surface = value_of(surfaces, i, 4);
    if (uv == nullptr || surface == nullptr) return SCREE_ERROR_CORRUPT;
    std::memcpy(&uvs[i], uv, sizeof *uvs);
    if (groups != nullptr) groups[i] = surface[3];
  }
  return SCREE_OK;
}

scree_result decode_lod(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices, size_t vertex_capacity,
                        void* indices, size_t index_capacity, uint32_t index_size) {
  scree_lod level;
  const scree_result result = scree_pack_get_lod(pack, asset, lod, &level);
  if (result != SCREE_OK) return result;
  if (lod + 1 == pack->header->lod_count)
    return scree_rt_pack_coarse_mesh(pack, asset, vertices, vertex_capacity, indices, index_size, index_capacity);
  if (index_size == sizeof(uint16_t) && level.vertices > UINT32_C(1) << 16) return SCREE_ERROR_CAPACITY;
  if (vertex_capacity < level.vertices || index_capacity / 3 < level.triangles) return SCREE_ERROR_CAPACITY;
  if ((vertices == nullptr && level.vertices > 0) || (indices == nullptr && level.triangles > 0))
    return SCREE_ERROR_INVALID_ARGUMENT;
  return scree_rt_draco_decode_blob(level.blob, level.blob_size, level.vertices, level.triangles, pack->kind, vertices, indices,
                                    index_size);
}

}  // namespace

scree_result scree_rt_draco_decode_blob(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                                        scree_pack_kind kind, scree_vertex* vertices, void* indices, uint32_t index_size) {
  if (triangle_count == 0) return vertex_count == 0 ? SCREE_OK : SCREE_ERROR_CORRUPT;
  try {
    return decode(blob, blob_size, vertex_count, triangle_count, kind, vertices, indices, index_size);
  } catch (const std::bad_alloc&) {
    return SCREE_ERROR_OUT_OF_MEMORY;
  } catch (...) {
    return SCREE_ERROR_CORRUPT;
  }
}

scree_result scree_draco_decode_u16(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                    size_t vertex_capacity, uint16_t* indices, size_t index_capacity) {
  return decode_lod(pack, asset, lod, vertices, vertex_capacity, indices, index_capacity, sizeof(uint16_t));
}

scree_result scree_draco_decode_u32(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                    size_t vertex_capacity, uint32_t* indices, size_t index_capacity) {
  return decode_lod(pack, asset, lod, vertices, vertex_capacity, indices, index_capacity, sizeof(uint32_t));
}

scree_result scree_rt_draco_decode_uvs(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                                       scree_uv* uvs, uint8_t* groups) {
  if (triangle_count == 0) return vertex_count == 0 ? SCREE_OK : SCREE_ERROR_CORRUPT;
  try {
    return decode_uvs(blob, blob_size, vertex_count, triangle_count, uvs, groups);
  } catch (const std::bad_alloc&) {
    return SCREE_ERROR_OUT_OF_MEMORY;
  } catch (...) {
    return SCREE_ERROR_CORRUPT;
  }
}

scree_result scree_draco_decode_uvs(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_uv* uvs, uint8_t* groups,
                                    size_t capacity) {
  if (pack == nullptr || pack->kind != SCREE_PACK_CLIFF) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_lod level;
  const scree_result result = scree_pack_get_lod(pack, asset, lod, &level);
  if (result != SCREE_OK) return result;
  if (lod + 1 == pack->header->lod_count) return scree_pack_coarse_uvs(pack, asset, uvs, groups, capacity);
  if (capacity < level.vertices) return SCREE_ERROR_CAPACITY;
  if (uvs == nullptr) return SCREE_ERROR_INVALID_ARGUMENT;
  return scree_rt_draco_decode_uvs(level.blob, level.blob_size, level.vertices, level.triangles, uvs, groups);
}
