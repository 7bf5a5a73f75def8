#version 450
in vec3 colour;
out vec4 pixel;
void main() { pixel = vec4(pow(colour, vec3(1.0 / 2.2)), 1.0); }
