layout(location = 0) in vec3 position; // metres
layout(location = 1) in vec3 normal;

uniform uint solid_tags;

out vec3 v_normal;
out float v_visibility;
out float v_depth;
flat out uvec4 v_tags;

void main() {
  gl_Position = clip_from_world * vec4(position, 1.0);
  v_normal = normal;
  v_visibility = 1.0;
  v_depth = dot(position - eye.xyz, forward.xyz);
  v_tags = uvec4(0u, solid_tags, 0u, 0u);
}
