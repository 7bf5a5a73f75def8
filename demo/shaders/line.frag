in float v_across;

uniform float half_width;
uniform vec4 colour;

out vec4 shown;

void main() { shown = vec4(colour.rgb, colour.a * clamp(half_width - abs(v_across), 0.0, 1.0)); }
