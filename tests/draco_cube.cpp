#include "draco_cube.h"

#include <draco/compression/encode.h>

#include <cstring>
#include <vector>

template <typename T>
static uint32_t add(draco::Mesh& mesh, draco::GeometryAttribute::Type kind, draco::DataType type, int8_t components,
                    const T* values, uint32_t count) {
  const int64_t stride = int64_t(sizeof(T)) * components;
  draco::GeometryAttribute attribute;
  attribute.Init(kind, nullptr, uint8_t(components), type, false, stride, 0);
  const int id = mesh.AddAttribute(attribute, true, count);
  mesh.attribute(id)->buffer()->Write(0, values, size_t(stride) * count);
  return mesh.attribute(id)->unique_id();
}

extern "C" size_t draco_cube_encode(const float* positions, const float* uvs, uint32_t vertex_count, const uint16_t* indices,
                                    uint32_t triangle_count, uint32_t one, char* bytes, size_t capacity) {
  draco::Mesh mesh;
  mesh.set_num_points(vertex_count);
  mesh.SetNumFaces(triangle_count);
  for (uint32_t i = 0; i < triangle_count; ++i) {
    draco::Mesh::Face face;
    for (size_t k = 0; k < 3; ++k) face[k] = draco::PointIndex(indices[3 * size_t(i) + k]);
    mesh.SetFace(draco::FaceIndex(i), face);
  }
  std::vector<uint8_t> narrow;
  std::vector<uint16_t> wide;
  for (size_t i = 0; i < size_t(vertex_count) * 2; ++i) {
    const uint32_t value = uint32_t(uvs[i] * float(one) + 0.5f);
    narrow.push_back(uint8_t(value & 255));
    wide.push_back(uint16_t(value));
  }
  const auto kind = draco::GeometryAttribute::TEX_COORD;
  const uint32_t place = add(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, positions, vertex_count);
  const uint32_t coordinates = one == 0     ? add(mesh, kind, draco::DT_FLOAT32, 2, uvs, vertex_count)
                               : one == 255 ? add(mesh, kind, draco::DT_UINT8, 2, narrow.data(), vertex_count)
                                            : add(mesh, kind, draco::DT_UINT16, 2, wide.data(), vertex_count);
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  if (place != 0 || coordinates != 1 || !encoder.EncodeMeshToBuffer(mesh, &buffer).ok() || buffer.size() > capacity) return 0;
  std::memcpy(bytes, buffer.data(), buffer.size());
  return buffer.size();
}
