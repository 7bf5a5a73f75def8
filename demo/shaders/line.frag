in float v_across;
flat in vec4 v_colour;

uniform float half_width;
uniform float opacity;

out vec4 shown;

void main() { shown = vec4(v_colour.rgb, v_colour.a * opacity * clamp(half_width - abs(v_across), 0.0, 1.0)); }
