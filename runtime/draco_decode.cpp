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

namespace {

// An attribute of ours: plain values without gaps, one a vertex, of exactly this type.
const draco::PointAttribute* plain_attribute(const draco::Mesh& mesh, draco::GeometryAttribute::Type kind, draco::DataType type,
                                             int components) {
  const draco::PointAttribute* attribute = mesh.GetNamedAttribute(kind);
  if (attribute == nullptr || attribute->data_type() != type || attribute->num_components() != components) return nullptr;
  const int64_t stride = int64_t{components} * draco::DataTypeLength(type);
  if (attribute->byte_stride() != stride || attribute->byte_offset() != 0) return nullptr;
  if (static_cast<int64_t>(attribute->buffer()->data_size()) < stride * static_cast<int64_t>(attribute->size())) return nullptr;
  return attribute;
}

// Writes position and occlusion of every vertex. Returns false when a vertex has no value.
bool copy_vertices(const draco::PointAttribute& positions, const draco::PointAttribute& occlusion, uint32_t vertex_count,
                   scree_vertex* vertices) {
  const uint8_t* position_bytes = positions.buffer()->data();
  const uint8_t* occlusion_bytes = occlusion.buffer()->data();
  const bool identity = positions.is_mapping_identity() && occlusion.is_mapping_identity();
  if (identity && (positions.size() < vertex_count || occlusion.size() < vertex_count)) return false;
  for (uint32_t i = 0; i < vertex_count; ++i) {
    uint32_t p = i, o = i;
    if (!identity) {
      p = positions.mapped_index(draco::PointIndex(i)).value();
      o = occlusion.mapped_index(draco::PointIndex(i)).value();
      if (p >= positions.size() || o >= occlusion.size()) return false;
    }
    scree_vertex vertex = {};
    std::memcpy(vertex.position, position_bytes + size_t{p} * sizeof vertex.position, sizeof vertex.position);
    vertex.occlusion = occlusion_value(occlusion_bytes[o]);
    vertices[i] = vertex;
  }
  return true;
}

// Copies the triangles. Returns false when one names a vertex that is not there.
bool copy_indices(const draco::Mesh& mesh, uint32_t vertex_count, uint32_t* indices) {
  uint32_t greatest = 0;
  for (uint32_t face = 0; face < mesh.num_faces(); ++face) {
    const draco::Mesh::Face& corners = mesh.face(draco::FaceIndex(face));
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t index = corners[i].value();
      greatest = index > greatest ? index : greatest;
      indices[3 * size_t{face} + i] = index;
    }
  }
  return greatest < vertex_count;
}

scree_result decode(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count, scree_vertex* vertices,
                    void* indices, uint32_t index_size) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(blob), blob_size);
  draco::Mesh mesh;
  draco::Decoder decoder;
  if (!decoder.DecodeBufferToGeometry(&buffer, &mesh).ok()) return SCREE_ERROR_CORRUPT;
  if (mesh.num_points() != vertex_count || mesh.num_faces() != triangle_count) return SCREE_ERROR_CORRUPT;
  const draco::PointAttribute* positions = plain_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_INT16, 3);
  const draco::PointAttribute* occlusion = plain_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 1);
  if (positions == nullptr || occlusion == nullptr) return SCREE_ERROR_CORRUPT;

  // Checked in memory of our own first, so that a bad blob leaves no index out of range in the caller's buffers.
  const size_t index_count = 3 * size_t{triangle_count};
  std::vector<uint32_t> wide(index_count);
  if (!copy_indices(mesh, vertex_count, wide.data())) return SCREE_ERROR_CORRUPT;
  if (!copy_vertices(*positions, *occlusion, vertex_count, vertices)) return SCREE_ERROR_CORRUPT;
  std::unique_ptr<int64_t[][4]> sums(new int64_t[vertex_count][4]);
  mesh_normals(vertices, vertex_count, wide.data(), triangle_count, sums.get());

  if (index_size == sizeof(uint32_t)) {
    std::memcpy(indices, wide.data(), index_count * sizeof(uint32_t));
  } else {
    uint16_t* narrow = static_cast<uint16_t*>(indices);
    for (size_t i = 0; i < index_count; ++i) narrow[i] = static_cast<uint16_t>(wide[i]);
  }
  return SCREE_OK;
}

scree_result decode_lod(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices, size_t vertex_capacity,
                        void* indices, size_t index_capacity, uint32_t index_size) {
  scree_lod level;
  const scree_result result = scree_pack_get_lod(pack, asset, lod, &level);
  if (result != SCREE_OK) return result;
  if (index_size == sizeof(uint16_t) && level.vertices > UINT32_C(1) << 16) return SCREE_ERROR_CAPACITY;
  if (vertex_capacity < level.vertices || index_capacity / 3 < level.triangles) return SCREE_ERROR_CAPACITY;
  if ((vertices == nullptr && level.vertices > 0) || (indices == nullptr && level.triangles > 0))
    return SCREE_ERROR_INVALID_ARGUMENT;
  return draco_decode_blob(level.blob, level.blob_size, level.vertices, level.triangles, vertices, indices, index_size);
}

}  // namespace

scree_result draco_decode_blob(const uint8_t* blob, size_t blob_size, uint32_t vertex_count, uint32_t triangle_count,
                               scree_vertex* vertices, void* indices, uint32_t index_size) {
  if (triangle_count == 0) return vertex_count == 0 ? SCREE_OK : SCREE_ERROR_CORRUPT;
  try {
    return decode(blob, blob_size, vertex_count, triangle_count, vertices, indices, index_size);
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
