// A segment as a ribbon that faces the eye and is so many pixels wide at any distance.
layout(location = 0) in vec3 from;
layout(location = 1) in vec3 to;
layout(location = 2) in vec4 colour;

uniform float half_width; // pixels, with one more for the soft rim

out float v_across;
flat out vec4 v_colour;

void main() {
  vec4 a = clip_from_world * vec4(from, 1.0), b = clip_from_world * vec4(to, 1.0);
  // Clip at the eye's plane first: behind it, the division turns a ribbon inside out.
  const float NEAREST = 1e-3;
  if (a.w < NEAREST) a = mix(a, b, (NEAREST - a.w) / max(b.w - a.w, 1e-6));
  if (b.w < NEAREST) b = mix(b, a, (NEAREST - b.w) / max(a.w - b.w, 1e-6));
  vec2 on_screen = (b.xy / b.w - a.xy / a.w) * size.xy;
  vec2 along = length(on_screen) > 1e-6 ? normalize(on_screen) : vec2(1.0, 0.0);
  vec4 here = (gl_VertexID & 1) == 0 ? a : b;
  v_colour = colour;
  v_across = (gl_VertexID & 2) == 0 ? -half_width : half_width;
  here.xy += vec2(-along.y, along.x) * v_across * 2.0 * size.zw * here.w;
  gl_Position = here;
}
