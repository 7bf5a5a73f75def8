#include "glb_scene.h"

#include <draco/compression/decode.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "support_file_gltf.h"

namespace {

struct wrong : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void check(bool good, const std::string& what) {
  if (!good) throw wrong(what);
}

/* All numbers of an accessor, as floats. */
std::vector<float> numbers(const tinygltf::Model& model, int index, int type) {
  const tinygltf::Accessor& a = model.accessors.at(size_t(index));
  check(a.type == type, "an accessor has another type than its use");
  check(a.bufferView >= 0, "an accessor has no buffer view");
  const tinygltf::BufferView& v = model.bufferViews.at(size_t(a.bufferView));
  const std::vector<unsigned char>& data = model.buffers.at(size_t(v.buffer)).data;
  const size_t components = size_t(tinygltf::GetNumComponentsInType(uint32_t(type)));
  const size_t size = size_t(tinygltf::GetComponentSizeInBytes(uint32_t(a.componentType)));
  const size_t stride = v.byteStride != 0 ? v.byteStride : components * size;
  check(v.byteOffset + v.byteLength <= data.size(), "a buffer view reaches past its buffer");
  check(a.byteOffset + (a.count - 1) * stride + components * size <= v.byteLength, "an accessor reaches past its view");
  check((v.byteOffset + a.byteOffset) % size == 0, "an accessor is not aligned");
  std::vector<float> out;
  for (size_t i = 0; i < a.count; ++i) {
    for (size_t k = 0; k < components; ++k) {
      const unsigned char* from = data.data() + v.byteOffset + a.byteOffset + i * stride + k * size;
      float value = 0;
      uint32_t whole = 0;
      if (a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
        std::memcpy(&value, from, 4);
      } else {
        std::memcpy(&whole, from, size);
        value = float(whole);
        if (a.normalized) value /= size == 1 ? 255.0f : 65535.0f;
      }
      check(std::isfinite(value), "a number is not finite");
      out.push_back(value);
    }
  }
  return out;
}

struct shape {
  std::vector<float> positions, normals, colours, uvs; /* uvs: empty where there are none */
  std::vector<uint32_t> indices;
};

/* Numbers of a Draco attribute, found by its unique id as the specification says. */
std::vector<float> attribute(const draco::Mesh& mesh, const tinygltf::Value& ids, const char* name, size_t components) {
  check(ids.Has(name), std::string("Draco: no id for ") + name);
  const draco::PointAttribute* a = mesh.GetAttributeByUniqueId(uint32_t(ids.Get(name).Get<int>()));
  check(a != nullptr, std::string("Draco: no attribute with the id of ") + name);
  check(size_t(a->num_components()) == components, std::string("Draco: wrong components of ") + name);
  std::vector<float> out(mesh.num_points() * components);
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
    check(a->ConvertValue<float>(a->mapped_index(i), int8_t(components), &out[i.value() * components]), "Draco: value");
  }
  return out;
}

shape load_draco(const tinygltf::Model& model, const tinygltf::Primitive& p, const tinygltf::Value& extension) {
  const tinygltf::BufferView& v = model.bufferViews.at(size_t(extension.Get("bufferView").Get<int>()));
  const std::vector<unsigned char>& data = model.buffers.at(size_t(v.buffer)).data;
  check(v.byteOffset + v.byteLength <= data.size(), "a Draco view reaches past its buffer");
  check(v.byteStride == 0 && v.target == 0, "a Draco view has a stride or a target");
  draco::DecoderBuffer bytes;
  bytes.Init(reinterpret_cast<const char*>(data.data() + v.byteOffset), v.byteLength);
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&bytes);
  check(decoded.ok(), "Draco refuses a mesh");
  const draco::Mesh& mesh = *decoded.value();
  const tinygltf::Value& ids = extension.Get("attributes");
  for (const auto& named : p.attributes) {
    const tinygltf::Accessor& a = model.accessors.at(size_t(named.second));
    check(a.count == mesh.num_points(), "the accessor of " + named.first + " counts other points than Draco");
    check(a.bufferView < 0, "an accessor of a Draco mesh has a buffer view");
  }
  check(ids.Size() == p.attributes.size(), "Draco and the mesh have different attributes");
  const tinygltf::Accessor& list = model.accessors.at(size_t(extension.Get("indices").Get<int>()));
  check(list.count == size_t(mesh.num_faces()) * 3, "the accessor of the indices counts others than Draco");
  check(list.type == TINYGLTF_TYPE_SCALAR, "indices are no scalars");
  check(list.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT || mesh.num_points() <= 65535, "16-bit indices are too few");
  shape out;
  out.positions = attribute(mesh, ids, "POSITION", 3);
  out.normals = attribute(mesh, ids, "NORMAL", 3);
  out.colours = attribute(mesh, ids, "COLOR_0", 4);
  if (p.attributes.count("TEXCOORD_0") > 0) {
    const tinygltf::Accessor& a = model.accessors.at(size_t(p.attributes.at("TEXCOORD_0")));
    check(a.type == TINYGLTF_TYPE_VEC2 && a.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT, "UVs are no two floats");
    out.uvs = attribute(mesh, ids, "TEXCOORD_0", 2);
  }
  for (float& value : out.colours) value = value > 1 ? value / 255 : value;
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
    for (size_t k = 0; k < 3; ++k) out.indices.push_back(mesh.face(f)[k].value());
  }
  for (float value : out.positions) check(value == std::floor(value), "a Draco position is no whole lattice step");
  return out;
}

shape load_plain(const tinygltf::Model& model, const tinygltf::Primitive& p) {
  shape out;
  out.positions = numbers(model, p.attributes.at("POSITION"), TINYGLTF_TYPE_VEC3);
  out.normals = numbers(model, p.attributes.at("NORMAL"), TINYGLTF_TYPE_VEC3);
  out.colours = numbers(model, p.attributes.at("COLOR_0"), TINYGLTF_TYPE_VEC4);
  if (p.attributes.count("TEXCOORD_0") > 0) out.uvs = numbers(model, p.attributes.at("TEXCOORD_0"), TINYGLTF_TYPE_VEC2);
  check(p.indices >= 0, "a mesh has no indices");
  for (float index : numbers(model, p.indices, TINYGLTF_TYPE_SCALAR)) out.indices.push_back(uint32_t(index));
  return out;
}

/* What a rock of this primitive is, before it is placed. */
glb_rock measure(const tinygltf::Model& model, const tinygltf::Primitive& p) {
  auto draco_extension = p.extensions.find("KHR_draco_mesh_compression");
  shape s = draco_extension != p.extensions.end() ? load_draco(model, p, draco_extension->second) : load_plain(model, p);
  const size_t count = s.positions.size() / 3;
  check(count > 0 && s.normals.size() == count * 3 && s.colours.size() == count * 4, "attributes of different length");
  check(s.uvs.empty() || s.uvs.size() == count * 2, "attributes of different length");
  glb_rock rock{};
  rock.has_uvs = !s.uvs.empty();
  rock.is_grey = 1;
  rock.vertices = uint32_t(count);
  rock.triangles = uint32_t(s.indices.size() / 3);
  rock.shape = uint32_t(p.attributes.at("POSITION"));
  const tinygltf::Accessor& place = model.accessors.at(rock.shape);
  check(place.minValues.size() == 3 && place.maxValues.size() == 3, "positions without bounds");
  for (size_t k = 0; k < 3; ++k) {
    rock.min[k] = rock.max[k] = double(s.positions[k]);
    for (size_t i = 0; i < count; ++i) {
      rock.min[k] = std::min(rock.min[k], double(s.positions[3 * i + k]));
      rock.max[k] = std::max(rock.max[k], double(s.positions[3 * i + k]));
    }
    check(float(place.minValues[k]) == float(rock.min[k]) && float(place.maxValues[k]) == float(rock.max[k]), "wrong bounds");
  }
  for (size_t i = 0; i < count; ++i) {
    const float* n = &s.normals[3 * i];
    check(std::fabs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-3f, "a normal is not of unit length");
    check(s.colours[4 * i + 3] == 1.0f, "a vertex colour is not opaque");
    rock.is_grey = rock.is_grey && s.colours[4 * i] == s.colours[4 * i + 1] && s.colours[4 * i] == s.colours[4 * i + 2];
  }
  double agreement = 0;
  for (size_t i = 0; i + 2 < s.indices.size(); i += 3) {
    const float* c[3];
    for (size_t k = 0; k < 3; ++k) {
      check(s.indices[i + k] < count, "an index points past the last vertex");
      c[k] = &s.positions[3 * size_t(s.indices[i + k])];
    }
    double u[3], v[3];
    for (size_t k = 0; k < 3; ++k) u[k] = double(c[1][k]) - double(c[0][k]), v[k] = double(c[2][k]) - double(c[0][k]);
    const double area[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    for (size_t k = 0; k < 3; ++k) {
      rock.volume += double(c[0][k]) * area[k] / 6;
      for (size_t corner = 0; corner < 3; ++corner) agreement += area[k] * double(s.normals[3 * size_t(s.indices[i + corner]) + k]);
    }
  }
  check(agreement > 0, "normals point inwards");
  for (size_t i = 0; i < s.indices.size() && rock.has_uvs != 0; ++i) {
    const float* at = &s.positions[3 * size_t(s.indices[i])];
    const double weight = double(at[0]) + 2 * double(at[1]) + 3 * double(at[2]);
    for (size_t k = 0; k < 2; ++k) rock.uv_sums[k] += weight * double(s.uvs[2 * size_t(s.indices[i]) + k]);
  }
  return rock;
}

/* Two primitives of one mesh. */
glb_rock both(glb_rock rock, const glb_rock& more) {
  check(rock.has_uvs == more.has_uvs, "a primitive has UVs, another none");
  rock.vertices += more.vertices;
  rock.triangles += more.triangles;
  rock.cut_triangles += more.cut_triangles;
  rock.volume += more.volume;
  rock.is_grey = rock.is_grey && more.is_grey;
  for (size_t k = 0; k < 2; ++k) rock.uv_sums[k] += more.uv_sums[k];
  for (size_t k = 0; k < 3; ++k) {
    rock.min[k] = std::min(rock.min[k], more.min[k]);
    rock.max[k] = std::max(rock.max[k], more.max[k]);
  }
  return rock;
}

struct reader {
  const tinygltf::Model& model;
  std::map<int, glb_rock> meshes;
  std::vector<glb_rock> rocks;

  const glb_rock& mesh(int index) {
    auto known = meshes.find(index);
    if (known != meshes.end()) return known->second;
    const tinygltf::Mesh& m = model.meshes.at(size_t(index));
    glb_rock rock{};
    check(!m.primitives.empty(), "a mesh has no primitives");
    for (size_t i = 0; i < m.primitives.size(); ++i) {
      const tinygltf::Material& material = model.materials.at(size_t(m.primitives[i].material));
      glb_rock more = measure(model, m.primitives[i]);
      more.cut_triangles = material.name == "cut" ? more.triangles : 0;
      for (size_t k = 0; k < 3; ++k) more.base[k] = float(material.pbrMetallicRoughness.baseColorFactor[k]);
      rock = i == 0 ? more : both(rock, more);
    }
    return meshes[index] = rock;
  }

  /* Sine and cosine of a unit quaternion, which has to turn about +Y. */
  template <typename T>
  static void turn_of(const T* q, double* turn) {
    const double y = double(q[1]), w = double(q[3]);
    check(q[0] == 0 && q[2] == 0, "a turn about another axis than +Y");
    check(std::fabs(y * y + w * w - 1) < 1e-6, "a quaternion is not of unit length");
    turn[0] = 2 * y * w;
    turn[1] = w * w - y * y;
  }

  /* Nodes only move, scale evenly and, those of one rock, turn about +Y: that is all the writer uses. */
  void node(int index, const double* origin, double scale) {
    const tinygltf::Node& n = model.nodes.at(size_t(index));
    double place[3] = {origin[0], origin[1], origin[2]}, own = scale;
    for (size_t k = 0; k < 3 && n.translation.size() == 3; ++k) place[k] += scale * n.translation[k];
    if (n.scale.size() == 3) {
      check(n.scale[0] == n.scale[1] && n.scale[1] == n.scale[2], "uneven scale");
      own *= n.scale[0];
    }
    check(n.matrix.empty(), "a node has a matrix");
    double turn[2] = {0, 1};
    if (n.rotation.size() == 4) turn_of(n.rotation.data(), turn);
    check(n.rotation.empty() || n.children.empty(), "a node turns others");
    auto instancing = n.extensions.find("EXT_mesh_gpu_instancing");
    if (instancing != n.extensions.end()) {
      instances(n, instancing->second.Get("attributes"), place, own);
    } else if (n.mesh >= 0) {
      glb_rock rock = mesh(n.mesh);
      const float white[3] = {1, 1, 1};
      add(rock, place, own, turn, white);
    }
    for (int child : n.children) node(child, place, own);
  }

  void instances(const tinygltf::Node& n, const tinygltf::Value& attributes, const double* place, double scale) {
    check(n.mesh >= 0, "instances of no mesh");
    const std::vector<float> t = numbers(model, attributes.Get("TRANSLATION").Get<int>(), TINYGLTF_TYPE_VEC3);
    const std::vector<float> c = numbers(model, attributes.Get("_COLOR_0").Get<int>(), TINYGLTF_TYPE_VEC3);
    check(t.size() == c.size(), "instance attributes of different length");
    std::vector<float> r, s;
    if (attributes.Has("ROTATION")) r = numbers(model, attributes.Get("ROTATION").Get<int>(), TINYGLTF_TYPE_VEC4);
    if (attributes.Has("SCALE")) s = numbers(model, attributes.Get("SCALE").Get<int>(), TINYGLTF_TYPE_VEC3);
    check(r.empty() || r.size() / 4 == t.size() / 3, "as many rotations as places");
    check(s.empty() || s.size() == t.size(), "as many scales as places");
    for (size_t i = 0; i < t.size(); i += 3) {
      double at[3], turn[2] = {0, 1};
      for (size_t k = 0; k < 3; ++k) at[k] = place[k] + scale * double(t[i + k]);
      if (!r.empty()) turn_of(&r[i / 3 * 4], turn);
      check(s.empty() || (s[i] == s[i + 1] && s[i] == s[i + 2]), "uneven scale");
      add(mesh(n.mesh), at, scale * (s.empty() ? 1 : double(s[i])), turn, &c[i]);
    }
  }

  void add(glb_rock rock, const double* place, double scale, const double* turn, const float* colour) {
    rock.turn[0] = turn[0];
    rock.turn[1] = turn[1];
    for (size_t k = 0; k < 3; ++k) {
      rock.position[k] = place[k];
      rock.min[k] *= scale;
      rock.max[k] *= scale;
      rock.colour[k] = rock.base[k] * colour[k];
    }
    rock.volume *= scale * scale * scale;
    for (double& sum : rock.uv_sums) sum *= scale;
    rocks.push_back(rock);
  }
};

bool has(const std::vector<std::string>& names, const char* name) {
  for (const std::string& n : names) {
    if (n == name) return true;
  }
  return false;
}

void load(const char* path, glb_scene& out) {
  std::ifstream file(path, std::ios::binary);
  check(bool(file), "cannot be opened");
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, 4);
  check(length == bytes.size(), "the header names another length than the file has");
  tinygltf::Model model;
  gltf_load(bytes.data(), bytes.size(), path, model);
  reader r{model, {}, {}};
  const double origin[3] = {0, 0, 0};
  for (int root : model.scenes.at(0).nodes) r.node(root, origin, 1);
  std::set<uint32_t> shapes;
  for (const auto& mesh : r.meshes) shapes.insert(mesh.second.shape);
  check(r.meshes.size() == model.meshes.size(), "meshes that nothing uses");
  out.shape_count = uint32_t(shapes.size());
  out.mesh_count = uint32_t(model.meshes.size());
  out.node_count = uint32_t(model.nodes.size());
  out.material_count = uint32_t(model.materials.size());
  out.needs_draco = has(model.extensionsRequired, "KHR_draco_mesh_compression");
  out.needs_instancing = has(model.extensionsRequired, "EXT_mesh_gpu_instancing");
  check(model.extensionsUsed == model.extensionsRequired, "extensions are used but not required");
  out.rock_count = r.rocks.size();
  out.rocks = static_cast<glb_rock*>(std::malloc((r.rocks.size() + 1) * sizeof(glb_rock)));
  check(out.rocks != nullptr, "out of memory");
  if (!r.rocks.empty()) std::memcpy(out.rocks, r.rocks.data(), r.rocks.size() * sizeof(glb_rock));
}

}  // namespace

int glb_scene_load(const char* path, glb_scene* out) {
  *out = glb_scene{};
  try {
    load(path, *out);
    return 1;
  } catch (const std::exception& e) {
    std::snprintf(out->message, sizeof out->message, "%s: %s", path, e.what());
    return 0;
  }
}

void glb_scene_free(glb_scene* scene) {
  std::free(scene->rocks);
  *scene = glb_scene{};
}
