// Vertices are fetched from textures by index. Frames are uploaded as received, the GPU interpolates between two frames, and
// flat normals are screen-space derivatives, so the script computes nothing when the frame changes.

const kFetch = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
uniform sampler2D posA, posB;
uniform float blend;
uniform vec3 center;
uniform float scale;
vec3 at(sampler2D positions, int vertex) {
  int width = textureSize(positions, 0).x;
  return texelFetch(positions, ivec2(vertex % width, vertex / width), 0).xyz;
}
vec3 vertexPosition(int vertex) {
  return (mix(at(posA, vertex), at(posB, vertex), blend) - center) * scale;
}
`;

export const kSurfaceVertex = /* glsl */ `
${kFetch}
in uint vertex;
uniform sampler2D refA, refB;
uniform usampler2D faces, crosses;
uniform int triangles;
uniform int surface;       // 0 plain, 1 level, 2 margin, 3 error
uniform bool hasFaces, showCollisions, showCrossings;
uniform float errorScale;
uniform vec3 plain, red;
uniform vec3 reasonColors[8];
uniform vec3 marginRamp[9];
uniform vec3 nothing;
out vec3 eye;
out vec3 corner;
out float distanceRatio;
flat out vec3 color;
flat out int marked;         // 1 collides in the step, 2 crosses in the first frame, 3 both

uint faceData(int plane, int face) {
  int width = textureSize(faces, 0).x;
  int k = plane * triangles + face;
  return texelFetch(faces, ivec2(k % width, k / width), 0).r;
}
vec3 levelColor(int level) {
  if (level < 0) return nothing;
  float pale = float(min(level, 15) * 12);
  return vec3(pale, 60.0 + pale, 128.0 + pale * 2.0 / 3.0) / 255.0;
}
void main() {
  int v = int(vertex), face = gl_VertexID / 3, side = gl_VertexID % 3;
  vec3 p = vertexPosition(v);
  vec4 seen = modelViewMatrix * vec4(p, 1.0);
  eye = seen.xyz;
  corner = vec3(side == 0, side == 1, side == 2);
  color = plain;
  marked = 0;
  distanceRatio = 0.0;
  if (hasFaces && surface != 3) {
    if (showCollisions && faceData(0, face) != 0u) marked = 1;
    if (surface == 1 || surface == 2) {
      int reason = int(faceData(1, face));
      int level = int(faceData(2, face));
      if (level > 127) level -= 256;
      color = reasonColors[min(reason, 7)];
      if (reason == 0 && surface == 1) color = levelColor(level);
      if (reason == 0 && surface == 2) {
        float margin = float(faceData(3, face)) / 255.0 * 8.0;
        int k = min(int(margin), 7);
        color = level < 0 ? nothing : mix(marginRamp[k], marginRamp[k + 1], margin - float(k));
      }
    }
  }
  if (surface == 3) {
    vec3 other = (mix(at(refA, v), at(refB, v), blend) - center) * scale;
    distanceRatio = length(p - other) / (scale * max(errorScale, 1e-30));
    if (hasFaces && showCollisions && faceData(0, face) != 0u) marked = 1;
  }
  if (showCrossings) {
    int width = textureSize(crosses, 0).x;
    if (texelFetch(crosses, ivec2(face % width, face / width), 0).r != 0u) marked += 2;
  }
  gl_Position = projectionMatrix * seen;
}
`;

export const kSurfaceFragment = /* glsl */ `
precision highp float;
precision highp int;
in vec3 eye;
in vec3 corner;
in float distanceRatio;
flat in vec3 color;
flat in int marked;
uniform int surface;
uniform vec3 red, pink, purple;
uniform vec3 errorRamp[9];
uniform bool edges, seeThrough;
uniform vec3 edgeColor;
out vec4 result;
void main() {
  bool stripe = mod(gl_FragCoord.x + gl_FragCoord.y, 9.0) < 4.5;
  // Every other pixel is discarded, so that surfaces behind are visible in any drawing order.
  if (seeThrough && marked == 0 && mod(floor(gl_FragCoord.x) + floor(gl_FragCoord.y), 2.0) < 0.5) discard;
  vec3 base = color;
  if (surface == 3) {
    float e = clamp(distanceRatio, 0.0, 1.0) * 8.0;
    int k = min(int(e), 7);
    base = mix(errorRamp[k], errorRamp[k + 1], e - float(k));
  }
  // Over meaningful colors, collisions are striped to distinguish them.
  if (marked == 1) base = surface == 0 || stripe ? red : vec3(1.0);
  // Crossings from the start are hatched the other way and dark, which distinguishes them from collisions in a step.
  if (marked >= 2) base = mod(gl_FragCoord.x - gl_FragCoord.y, 10.0) < 4.0 ? purple : marked == 2 ? pink : red;
  vec3 normal = cross(dFdx(eye), dFdy(eye));
  float size = length(normal);
  normal = size > 0.0 ? normal / size : vec3(0.0, 0.0, 1.0);
  vec3 key = normalize(vec3(-0.35, 0.55, 0.75));
  float lit = 0.50 + 0.38 * max(0.0, dot(normal, key)) + 0.14 * normal.z + 0.06 * normal.y;
  vec3 shaded = base * min(lit, 1.06);
  if (!gl_FrontFacing) shaded *= 0.72;
  if (edges) {
    vec3 width = fwidth(corner);
    vec3 near = smoothstep(vec3(0.0), width * 1.2, corner);
    float line = 1.0 - min(near.x, min(near.y, near.z));
    // Edges fade out where triangles are as small as pixels.
    float strength = 1.0 - smoothstep(0.15, 0.6, max(width.x, max(width.y, width.z)));
    shaded = mix(shaded, edgeColor, 0.75 * line * strength);
  }
  result = vec4(min(shaded, 1.0), 1.0);
}
`;

/** Round marks of a size in pixels. `filled`: those whose time of impact has passed. */
export const kPointVertex = /* glsl */ `
${kFetch}
#ifdef BY_VERTEX
in uint vertex;
uniform vec3 only;
#else
in vec3 position_;
in float toi;
uniform vec3 timeRamp[9];
uniform float now;
#endif
uniform float size;
out vec3 color;
out float filled;
void main() {
#ifdef BY_VERTEX
  vec3 p = vertexPosition(int(vertex));
  color = only;
  filled = 1.0;
#else
  vec3 p = position_;
  float e = clamp(toi, 0.0, 1.0) * 8.0;
  int k = min(int(e), 7);
  color = mix(timeRamp[k], timeRamp[k + 1], e - float(k));
  filled = now >= toi - 1e-6 ? 1.0 : 0.0;
#endif
  gl_Position = projectionMatrix * viewMatrix * vec4(p, 1.0);
  gl_Position.z -= 0.0004 * gl_Position.w; // in front of its surface
  gl_PointSize = size;
}
`;

export const kPointFragment = /* glsl */ `
precision highp float;
in vec3 color;
in float filled;
uniform float opacity, size;
out vec4 result;
void main() {
  float r = length(gl_PointCoord - 0.5) * 2.0;
  if (r > 1.0) discard;
  if (filled < 0.5 && r < 0.42) discard;
  // The rim is 1.5 pixels wide, and paler on small points, which it would otherwise dominate.
  bool rim = r > 1.0 - 3.0 / size;
  vec3 dark = size < 8.0 ? color * 0.45 : vec3(0.05, 0.07, 0.09);
  result = vec4(rim ? dark : color, opacity);
}
`;

/** Lines of a width in pixels between two vertices of the mesh. */
export const kLineVertex = /* glsl */ `
${kFetch}
in uint from, to;
in float end, across; // 0 or 1 along the line, -1 or 1 across it
uniform vec2 viewport;
uniform float width;
void main() {
  vec4 a = projectionMatrix * viewMatrix * vec4(vertexPosition(int(from)), 1.0);
  vec4 b = projectionMatrix * viewMatrix * vec4(vertexPosition(int(to)), 1.0);
  vec2 along = (b.xy / b.w - a.xy / a.w) * viewport;
  float size = length(along);
  along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
  vec4 p = mix(a, b, end);
  vec2 offset = vec2(-along.y, along.x) * across + along * (end * 2.0 - 1.0);
  p.xy += offset * width / viewport * p.w;
  gl_Position = p;
}
`;

export const kFlatFragment = /* glsl */ `
precision highp float;
uniform vec3 only;
uniform float opacity;
out vec4 result;
void main() { result = vec4(only, opacity); }
`;

export const kBoxVertex = /* glsl */ `
precision highp float;
in vec3 corner;
in vec3 low, high;
uniform vec3 center;
uniform float scale;
void main() {
  vec3 p = (mix(low, high, corner) - center) * scale;
  gl_Position = projectionMatrix * viewMatrix * vec4(p, 1.0);
}
`;
