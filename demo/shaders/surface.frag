in vec3 v_normal;
in float v_visibility;
in float v_depth;
flat in uvec4 v_tags;

uniform uint extra_tags;

layout(location = 0) out vec4 surface; // normal, baked visibility
layout(location = 1) out uvec4 tags;
layout(location = 2) out float depth; // along the view axis, metres

void main() {
  surface = vec4(normalize(v_normal), v_visibility);
  tags = uvec4(v_tags.x, v_tags.y | extra_tags, v_tags.zw);
  depth = v_depth;
}
