layout(location = 0) in vec3 position; // lattice steps
layout(location = 1) in vec3 normal;
layout(location = 2) in float visibility;
layout(location = 3) in vec4 place; // metres; w: metres per lattice step
layout(location = 4) in uvec4 tags; // hash, tags, stone + 1, colour
layout(location = 5) in vec2 turn;  // sine and cosine
layout(location = 6) in uint material;
layout(location = 7) in uint durability;
layout(location = 8) in int curvature;

out vec3 v_normal;
out float v_visibility;
out float v_depth;
out vec3 v_point;
out vec4 v_rock; // bed, share of colluvium, durability, curvature; of what is painted its colour; of cliffs 1 on cuts, 0, durability, curvature
flat out uvec4 v_tags;

uniform int look; // render_look

vec3 turned(vec3 v) { return vec3(turn.y * v.x + turn.x * v.z, v.y, turn.y * v.z - turn.x * v.x); }

void main() {
  vec3 world = place.xyz + turned(position) * place.w;
  gl_Position = clip_from_world * vec4(world, 1.0);
  v_normal = turned(normal);
  v_visibility = visibility;
  v_depth = dot(world - eye.xyz, forward.xyz);
  v_point = world;
  if (look == 2)
    v_rock = vec4(float(material), float(durability), float(curvature & 255), 0.0) * (1.0 / 255.0);
  else if (look == 3)
    v_rock = vec4((material & 15u) == 2u ? 1.0 : 0.0, 0.0, float(durability) * (4.0 / 255.0), float(curvature) * (1.0 / 127.0));
  else
    v_rock = vec4(float(material >> 4u), float(material & 15u), float(durability) * (4.0 / 255.0), float(curvature) * (1.0 / 127.0));
  v_tags = tags;
}
