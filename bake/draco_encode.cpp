// The only file that sees Draco's encoder. What was measured before these choices were made is in docs/codecs.md.
#include "draco_encode.h"

#include <draco/compression/expert_encode.h>

#include <cstring>
#include <memory>
#include <new>
#include <vector>

extern "C" {
#include "allocator.h"
#include "mesh_digest.h"
#include "mesh_normals.h"
#include "occlusion.h"
#include "uv_bytes.h"
}

namespace {

int add_attribute(draco::Mesh* mesh, draco::GeometryAttribute::Type kind, draco::DataType type, int components, const void* values,
                  uint32_t count) {
  const int64_t stride = int64_t{components} * draco::DataTypeLength(type);
  draco::GeometryAttribute attribute;
  attribute.Init(kind, nullptr, static_cast<uint8_t>(components), type, false, stride, 0);
  const int id = mesh->AddAttribute(attribute, true, count);
  mesh->attribute(id)->buffer()->Write(0, values, static_cast<size_t>(stride) * count);
  return id;
}

std::vector<float> normals_of(const lattice_mesh& mesh) {
  std::vector<scree_vertex> vertices(mesh.vertex_count);
  for (uint32_t i = 0; i < mesh.vertex_count; ++i)
    std::memcpy(vertices[i].position, mesh.positions[i], sizeof vertices[i].position);
  const std::unique_ptr<char[]> scratch(new char[size_t{mesh.vertex_count} * MESH_NORMALS_SCRATCH]);
  scree_rt_mesh_normals(vertices.data(), mesh.vertex_count, mesh.indices, mesh.triangle_count, scratch.get());
  std::vector<float> normals;
  for (const scree_vertex& vertex : vertices)
    for (const int16_t component : vertex.normal) normals.push_back(static_cast<float>(component) / 32767.0f);
  return normals;
}

bool triangles_are_sound(const lattice_mesh& mesh) {
  for (size_t i = 0; i < 3 * size_t{mesh.triangle_count}; i += 3) {
    const uint32_t* corner = mesh.indices + i;
    for (size_t k = 0; k < 3; ++k)
      if (corner[k] >= mesh.vertex_count || corner[k] == corner[(k + 1) % 3]) return false;
  }
  return true;
}

// Positions with the occlusion's levels as fourth component, and what the surfaces of models have beside them, and UVs; or, when a
// measurement asks for it, apart from it or without.
void add_vertices(const draco_encode_options& options, const lattice_mesh& mesh, const std::vector<uint8_t>& levels,
                  const std::vector<uint16_t>& uvs, draco::Mesh* out) {
  const bool together = options.occlusion_bits > 0 && !options.occlusion_apart;
  const int components = together ? 4 : 3;
  std::vector<int16_t> values;
  values.reserve(size_t{mesh.vertex_count} * 4);
  for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
    values.insert(values.end(), mesh.positions[i], mesh.positions[i] + 3);
    if (together) values.push_back(levels[i]);
  }
  add_attribute(out, draco::GeometryAttribute::POSITION, draco::DT_INT16, components, values.data(), mesh.vertex_count);
  if (mesh.surface != nullptr)
    add_attribute(out, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 4, mesh.surface, mesh.vertex_count);
  if (mesh.uvs != nullptr)
    add_attribute(out, draco::GeometryAttribute::TEX_COORD, draco::DT_UINT16, 2, uvs.data(), mesh.vertex_count);
  if (options.occlusion_bits > 0 && options.occlusion_apart)
    add_attribute(out, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 1, levels.data(), mesh.vertex_count);
}

scree_result encode(const draco_encode_options& options, const lattice_mesh& mesh, const scree_allocator* allocator,
                    rock_lod* out) {
  // Levels for the blob, and the values they will decode to for the digest.
  const unsigned greatest = (1u << options.occlusion_bits) - 1;
  std::vector<uint8_t> levels(mesh.vertex_count), values(mesh.vertex_count);
  for (uint32_t i = 0; i < mesh.vertex_count; ++i) {
    levels[i] = static_cast<uint8_t>((mesh.occlusion[i] * greatest + 127) / 255);
    values[i] = occlusion_value(levels[i]);
  }

  std::vector<uint16_t> uvs(mesh.uvs != nullptr ? 2 * size_t{mesh.vertex_count} : 0);
  for (uint32_t i = 0; mesh.uvs != nullptr && i < mesh.vertex_count; ++i) uv_values(&mesh, i, &uvs[2 * size_t{i}]);

  draco::Mesh input;
  input.set_num_points(mesh.vertex_count);
  input.SetNumFaces(mesh.triangle_count);
  for (uint32_t i = 0; i < mesh.triangle_count; ++i) {
    const uint32_t* corner = mesh.indices + 3 * size_t{i};
    input.SetFace(draco::FaceIndex(i), {draco::PointIndex(corner[0]), draco::PointIndex(corner[1]), draco::PointIndex(corner[2])});
  }
  add_vertices(options, mesh, levels, uvs, &input);

  draco::ExpertEncoder encoder(input);
  encoder.SetSpeedOptions(options.speed, options.speed);
  encoder.SetEncodingMethod(options.sequential ? draco::MESH_SEQUENTIAL_ENCODING : draco::MESH_EDGEBREAKER_ENCODING);
  if (options.connectivity >= 0) encoder.options().SetGlobalInt("edgebreaker_method", options.connectivity);
  if (options.keep_normals) {
    const std::vector<float> normals = normals_of(mesh);
    const int id = add_attribute(&input, draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3, normals.data(), mesh.vertex_count);
    encoder.SetAttributeQuantization(id, 8);
  }
  encoder.options().SetGlobalBool("split_mesh_on_seams", !options.separate_surfaces);
  encoder.SetTrackEncodedProperties(true);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok() || buffer.size() > UINT32_MAX) return SCREE_ERROR_INVALID_ARGUMENT;

  uint8_t* blob = static_cast<uint8_t*>(scree_rt_allocate(allocator, buffer.size(), 1));
  if (blob == nullptr) return SCREE_ERROR_OUT_OF_MEMORY;
  std::memcpy(blob, buffer.data(), buffer.size());
  out->blob = blob;
  out->blob_size = static_cast<uint32_t>(buffer.size());
  out->vertex_count = static_cast<uint32_t>(encoder.num_encoded_points());
  out->triangle_count = static_cast<uint32_t>(encoder.num_encoded_faces());
  const size_t stride = sizeof *mesh.positions;
  if (mesh.surface != nullptr)
    out->digest = scree_rt_model_digest(mesh.positions, stride, values.data(), mesh.surface,
                                        mesh.uvs != nullptr ? reinterpret_cast<const uint16_t(*)[2]>(uvs.data()) : nullptr,
                                        mesh.indices, mesh.triangle_count);
  else
    out->digest = scree_rt_mesh_digest(mesh.positions, stride, values.data(), 1, mesh.indices, mesh.triangle_count);
  return SCREE_OK;
}

}  // namespace

draco_encode_options draco_encode_defaults(void) {
  draco_encode_options options = {};
  options.speed = 5;
  options.connectivity = draco::MESH_EDGEBREAKER_STANDARD_ENCODING;
  options.occlusion_bits = OCCLUSION_BITS;
  return options;
}

scree_result draco_encode_with(const draco_encode_options* options, const lattice_mesh* mesh, const scree_allocator* given,
                               rock_lod* out) {
  const scree_allocator allocator = scree_rt_allocator_or_default(given);
  *out = rock_lod{};
  out->error = mesh->error;
  out->digest = scree_rt_mesh_digest(nullptr, 0, nullptr, 0, nullptr, 0);
  if (mesh->triangle_count == 0) return SCREE_OK;
  if (!triangles_are_sound(*mesh) || (mesh->uvs != nullptr && mesh->surface == nullptr)) return SCREE_ERROR_INVALID_ARGUMENT;
  try {
    return encode(*options, *mesh, &allocator, out);
  } catch (const std::bad_alloc&) {
    return SCREE_ERROR_OUT_OF_MEMORY;
  } catch (...) {
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
}

scree_result draco_encode(const lattice_mesh* mesh, const scree_allocator* allocator, rock_lod* out) {
  const draco_encode_options options = draco_encode_defaults();
  return draco_encode_with(&options, mesh, allocator, out);
}
