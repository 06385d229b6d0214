// Pictures, checked at single pixels.
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "picture/picture.h"

namespace foldproof {
namespace {

using ::testing::HasSubstr;

struct Mesh {
  Topology topology;
  std::vector<double> x;
  PictureMesh picture(Color color = colors::kClay) const { return {&topology, x, color}; }
};

Mesh sphere(Index around, Index along, const Vec3& center, double radius) {
  std::vector<double> x;
  std::vector<Triangle> triangles;
  for (Index i = 0; i <= along; ++i) {
    const double polar = std::numbers::pi * i / along;
    for (Index j = 0; j < around; ++j) {
      const double turn = 2 * std::numbers::pi * j / around;
      x.insert(x.end(),
               {center.x() + radius * std::sin(polar) * std::cos(turn), center.y() + radius * std::cos(polar),
                center.z() - radius * std::sin(polar) * std::sin(turn)});
      if (i == along) continue;
      const Index a = i * around + j, b = i * around + (j + 1) % around;
      triangles.push_back({a, a + around, b});
      triangles.push_back({b, a + around, b + around});
    }
  }
  return {*Topology::make(around * (along + 1), std::move(triangles)), std::move(x)};
}

/// A square at height z that faces the eye.
Mesh square(double half, double z, const Vec3& center = Vec3::Zero()) {
  const double x = center.x(), y = center.y();
  return {*Topology::make(4, {{0, 1, 2}, {0, 2, 3}}),
          {x - half, y - half, z, x + half, y - half, z, x + half, y + half, z, x - half, y + half, z}};
}

Color at(const Image& image, Index x, Index y) { return image.pixels[std::size_t{y} * image.width + x]; }

Image draw(std::vector<Panel> panels, const PictureSettings& settings) {
  auto image = draw_picture(panels, settings);
  EXPECT_TRUE(image) << image.error().line();
  return image ? *image : Image{1, 1, {Color{}}};
}

const View kFlat{.perspective = false};

TEST(Picture, SphereCoversADisc) {
  const Mesh sphere_mesh = sphere(128, 64, {3, -2, 7}, 5);
  for (const bool perspective : {false, true}) {
    SCOPED_TRACE(perspective);
    const Image image = draw({{.meshes = {sphere_mesh.picture()}, .view = {.perspective = perspective}}},
                             {.width = 300, .height = 200});
    ASSERT_EQ(image.pixels.size(), 60000u);
    // Fitted to 94 % of the height; in perspective the rim is behind the front that was fitted.
    double area = 0;
    Index left = 300, right = 0, top = 200, bottom = 0;
    for (Index y = 0; y < 200; ++y) {
      for (Index x = 0; x < 300; ++x) {
        if (at(image, x, y) == colors::kWhite) continue;
        ++area;
        left = std::min(left, x), right = std::max(right, x);
        top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
    const double radius = std::sqrt(area / std::numbers::pi);
    if (perspective) {
      EXPECT_GT(radius, 70);
      EXPECT_LT(radius, 94);
    } else {
      EXPECT_NEAR(radius, 94, 0.7);
    }
    EXPECT_NEAR(0.5 * (left + right), 149.5, 0.51);
    EXPECT_NEAR(0.5 * (top + bottom), 99.5, 0.51);
    EXPECT_NEAR(0.5 * (right - left + 1), radius, 1.2);  // round, and no holes
    EXPECT_NEAR(0.5 * (bottom - top + 1), radius, 1.2);
    EXPECT_NE(at(image, 150, 100), colors::kWhite);
  }
}

TEST(Picture, LightComesFromTheUpperLeft) {
  const Mesh sphere_mesh = sphere(64, 32, {0, 0, 0}, 1);
  const Image image = draw({{.meshes = {sphere_mesh.picture()}}}, {.width = 100, .height = 100});
  EXPECT_GT(at(image, 35, 35).green, at(image, 65, 65).green + 20);
  EXPECT_GT(at(image, 65, 65).green, 40);  // nothing is black
}

TEST(Picture, AFacingTriangleHasItsColor) {
  const Mesh wall = square(1, 0);
  for (const bool perspective : {false, true}) {
    const View view{.perspective = perspective};
    for (const Color color : {colors::kRed, colors::kBlue, Color{1, 2, 3}, Color{250, 128, 7}}) {
      const Image image =
          draw({{.meshes = {wall.picture(color)}, .view = view}}, {.width = 40, .height = 40});
      EXPECT_EQ(at(image, 20, 20), color);
      EXPECT_EQ(at(image, 3, 3), color);
      EXPECT_EQ(at(image, 0, 0), colors::kWhite);
    }
  }
  // And from behind.
  const Image image = draw({{.meshes = {wall.picture(colors::kRed)}, .view = {.from = {0, 0, -3}}}},
                           {.width = 40, .height = 40});
  EXPECT_EQ(at(image, 20, 20), colors::kRed);
}

TEST(Picture, NearHidesFar) {
  const Mesh far = square(1, -1), near = square(0.5, 1);
  for (const bool near_first : {true, false}) {
    for (const bool perspective : {true, false}) {
      std::vector<PictureMesh> meshes{far.picture(colors::kBlue), near.picture(colors::kRed)};
      if (near_first) std::swap(meshes[0], meshes[1]);
      const PictureSettings settings{.width = 60, .height = 60};
      const Image front = draw({{.meshes = meshes, .view = {.perspective = perspective}}}, settings);
      EXPECT_EQ(at(front, 30, 30), colors::kRed);
      EXPECT_EQ(at(front, 13, 30), colors::kBlue);
      const Image back =
          draw({{.meshes = meshes, .view = {.from = {0, 0, -1}, .perspective = perspective}}}, settings);
      EXPECT_EQ(at(back, 30, 30), colors::kBlue);
    }
  }
}

/// Two squares that cross: each is visible on the side where it is nearer.
TEST(Picture, CrossingTrianglesHideEachOtherInPart) {
  Mesh left_near = square(1, 0), right_near = square(1, 0);
  for (int k = 0; k < 4; ++k) {
    left_near.x[3 * k + 2] = -0.1 * left_near.x[3 * k];
    right_near.x[3 * k + 2] = 0.1 * right_near.x[3 * k];
  }
  const Image image =
      draw({{.meshes = {left_near.picture(colors::kRed), right_near.picture(colors::kBlue)}, .view = kFlat}},
           {.width = 60, .height = 60});
  for (Index x = 5; x < 55; ++x) {
    if (x == 29 || x == 30) continue;
    const Color c = at(image, x, 30);
    EXPECT_EQ(c.red > c.blue, x < 30) << x;
  }
}

/// A fan with its center anywhere: no gap between neighbors shows the square behind.
TEST(Picture, TrianglesWithACommonEdgeLeaveNoGap) {
  const Mesh behind = square(1, -0.5);
  for (const double skew : {0.0, 0.1, 1.0 / 3}) {
    std::vector<double> x{skew, skew * skew, 0};
    std::vector<Triangle> triangles;
    for (Index k = 0; k < 101; ++k) {
      const double turn = 2 * std::numbers::pi * k / 101;
      x.insert(x.end(), {2 * std::cos(turn), 2 * std::sin(turn), 0});
      triangles.push_back({0, 1 + k, 1 + (k + 1) % 101});
    }
    const Mesh fan{*Topology::make(102, std::move(triangles)), x};
    for (const bool perspective : {true, false}) {
      const Image image = draw({{.meshes = {behind.picture(colors::kRed), fan.picture(colors::kBlue)},
                                 .view = {.perspective = perspective, .focus = View::Focus{{0, 0, 0}, 1}}}},
                               {.width = 100, .height = 100});
      for (const Color c : image.pixels) ASSERT_EQ(c, colors::kBlue);
    }
  }
}

TEST(Picture, FaceColorsAreUsed) {
  const Mesh wall = square(1, 0);
  PictureMesh faces = wall.picture();
  const std::vector<Color> two{colors::kRed, colors::kBlue};
  faces.face_colors = two;
  const PictureSettings settings{.width = 100, .height = 100};
  const Image image = draw({{.meshes = {faces}, .view = kFlat}}, settings);
  EXPECT_EQ(at(image, 70, 80), colors::kRed);  // the lower right triangle is the first
  EXPECT_EQ(at(image, 30, 20), colors::kBlue);
}

TEST(Picture, SmoothAndFlatDiffer) {
  const Mesh sphere_mesh = sphere(12, 6, {0, 0, 0}, 1);
  PictureMesh flat = sphere_mesh.picture();
  flat.smooth = false;
  const PictureSettings settings{.width = 120, .height = 120};
  const auto shades = [](const Image& image) {
    std::vector<std::uint8_t> values;
    for (const Color c : image.pixels) values.push_back(c.green);
    std::sort(values.begin(), values.end());
    return std::unique(values.begin(), values.end()) - values.begin();
  };
  const Image smooth_image = draw({{.meshes = {sphere_mesh.picture()}}}, settings);
  const Image flat_image = draw({{.meshes = {flat}}}, settings);
  EXPECT_NE(smooth_image.pixels, flat_image.pixels);
  // Inside, one shade per facet against a gradient.
  const auto row = [&](const Image& image) {
    int changes = 0;
    for (Index x = 40; x < 80; ++x) changes += at(image, x, 52) != at(image, x + 1, 52);
    return changes;
  };
  EXPECT_LT(row(flat_image), 12);
  EXPECT_GT(row(smooth_image), 25);
  EXPECT_GT(shades(smooth_image), 50);
}

TEST(Picture, PointsAreSpheresOnTheSurface) {
  const Mesh wall = square(1, 0);
  Panel panel{.meshes = {wall.picture()},
              .points = {{{{0.5, 0.5, 0}, {-0.5, 0.5, -1}}, colors::kRed, 0.05}},
              .view = kFlat};
  const Image image = draw({panel}, {.width = 200, .height = 200});
  // 2 units of extent are 188 pixels; a radius of 0.05 of the extent is 9.4 pixels.
  EXPECT_GT(at(image, 147, 53).red, 1.5 * at(image, 147, 53).green);
  int red = 0;
  for (const Color c : image.pixels) red += c.red > 2 * c.green;
  EXPECT_NEAR(red, std::numbers::pi * 9.4 * 9.4, 30);  // the one behind the wall is hidden
  const Color upper = at(image, 144, 50), lower = at(image, 151, 57);
  EXPECT_GT(upper.red, lower.red + 20);  // and it is round
}

TEST(Picture, FocusShowsAPart) {
  const Mesh wall = square(1, 0);
  PictureMesh mesh = wall.picture();
  const std::vector<Color> two{colors::kRed, colors::kBlue};
  mesh.face_colors = two;
  for (const bool perspective : {true, false}) {
    View view{.perspective = perspective, .focus = View::Focus{{0.6, -0.6, 0}, 0.2}};
    const Image image = draw({{.meshes = {mesh}, .view = view}}, {.width = 50, .height = 50});
    for (const Color c : image.pixels) EXPECT_EQ(c, colors::kRed);
    view.focus->center = {1, 0, 0};
    const Image edge = draw({{.meshes = {mesh}, .view = view}}, {.width = 50, .height = 50});
    EXPECT_EQ(at(edge, 23, 40), colors::kRed);
    EXPECT_EQ(at(edge, 27, 40), colors::kWhite);
  }
}

TEST(Picture, PanelsAreSideBySide) {
  const Mesh small = square(0.5, 0), large = square(1, 0, {10, 20, 0});
  const std::vector<Panel> panels{{.meshes = {small.picture(colors::kRed)}, .view = kFlat},
                                  {.meshes = {large.picture(colors::kBlue)}, .view = kFlat},
                                  {.meshes = {small.picture(colors::kGreen)}, .view = kFlat}};
  const auto width_at = [](const Image& image, Index y, Color color) {
    Index count = 0;
    for (Index x = 0; x < image.width; ++x) count += at(image, x, y) == color;
    return count;
  };
  const Image row = draw(panels, {.width = 300, .height = 100});
  EXPECT_NEAR(width_at(row, 50, colors::kBlue), 94, 1);
  EXPECT_NEAR(width_at(row, 50, colors::kRed), 94, 1) << "each has its own scale";
  EXPECT_EQ(at(row, 50, 50), colors::kRed);
  EXPECT_EQ(at(row, 150, 50), colors::kBlue);
  EXPECT_EQ(at(row, 250, 50), colors::kGreen);
}

/// A cube's faces are flat, though its vertices are shared; a ball is round.
TEST(Picture, CreasesStaySharp) {
  std::vector<double> x;
  for (int v = 0; v < 8; ++v) x.insert(x.end(), {v & 1 ? 1.0 : -1, v & 2 ? 1.0 : -1, v & 4 ? 1.0 : -1});
  const Mesh cube{*Topology::make(8, {{0, 2, 3},
                                      {0, 3, 1},
                                      {4, 5, 7},
                                      {4, 7, 6},
                                      {0, 1, 5},
                                      {0, 5, 4},
                                      {2, 6, 7},
                                      {2, 7, 3},
                                      {0, 4, 6},
                                      {0, 6, 2},
                                      {1, 3, 7},
                                      {1, 7, 5}}),
                  x};
  PictureMesh smooth = cube.picture(), flat = smooth;
  flat.smooth = false;
  const View view{.from = {0.4, 0.3, 1}};
  const PictureSettings settings{.width = 60, .height = 60};
  EXPECT_EQ(draw({{.meshes = {smooth}, .view = view}}, settings).pixels,
            draw({{.meshes = {flat}, .view = view}}, settings).pixels);
}

TEST(Picture, LooksTheSameFarFromTheOrigin) {
  const Mesh here = sphere(64, 32, {0, 0, 0}, 1), there = sphere(64, 32, {1e6, -1e6, 1e6}, 1);
  const PictureSettings settings{.width = 80, .height = 80};
  const Image near = draw({{.meshes = {here.picture()}}}, settings);
  const Image far = draw({{.meshes = {there.picture()}}}, settings);
  for (std::size_t k = 0; k < near.pixels.size(); ++k) {
    ASSERT_NEAR(near.pixels[k].red, far.pixels[k].red, 2) << k;
  }
}

TEST(Picture, IsFittedToABox) {
  const Mesh wall = square(1, 0);
  View view = kFlat;
  view.fit = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(3, 1, 0));
  const Image image =
      draw({{.meshes = {wall.picture(colors::kRed)}, .view = view}}, {.width = 100, .height = 50});
  EXPECT_EQ(at(image, 25, 25), colors::kRed);
  EXPECT_EQ(at(image, 75, 25), colors::kWhite);
}

TEST(Picture, TheBackgroundMayBeTransparent) {
  const Mesh wall = square(1, 0);
  const Image image = draw({{.meshes = {wall.picture(colors::kRed)}, .view = kFlat}},
                           {.width = 60, .height = 40, .background = std::nullopt});
  ASSERT_EQ(image.alpha.size(), image.pixels.size());
  EXPECT_EQ(image.alpha[0], 0);
  EXPECT_EQ(image.alpha[20 * 60 + 30], 255);
  // At an edge, the color is that of the mesh: nothing shines through from a background.
  std::size_t edge = 0;
  for (std::size_t k = 0; k < image.pixels.size(); ++k) {
    if (image.alpha[k] == 0) continue;
    EXPECT_EQ(image.pixels[k], colors::kRed);
    edge += image.alpha[k] < 255;
  }
  EXPECT_GT(edge, 0u);
}

TEST(Picture, EdgesAreSmoothed) {
  const Mesh wall = square(1, 0);
  View turned = kFlat;
  turned.up = {0.3, 1, 0};
  const auto grays = [&](Index samples) {
    const Image image = draw({{.meshes = {wall.picture({0, 0, 0})}, .view = turned}},
                             {.width = 64, .height = 64, .samples = samples});
    std::set<int> values;
    for (const Color c : image.pixels) values.insert(c.red);
    return values.size();
  };
  EXPECT_EQ(grays(1), 2u);
  EXPECT_GT(grays(4), 10u);
}

TEST(Picture, TheSameForAnyNumberOfThreads) {
  const Mesh sphere_mesh = sphere(200, 100, {0, 0, 0}, 1);
  const std::vector<Panel> panels{{.meshes = {sphere_mesh.picture()}, .points = {{{{0, 0, 1}}}}}};
  const Image many = draw(panels, {.width = 333, .height = 211});
  const ThreadLimit one(1);
  EXPECT_EQ(many.pixels, draw(panels, {.width = 333, .height = 211}).pixels);
}

TEST(Picture, DegenerateInputIsDrawn) {
  const PictureSettings settings{.width = 20, .height = 20};
  const Image empty = draw({Panel{}}, settings);
  EXPECT_EQ(at(empty, 10, 10), colors::kWhite);
  // All vertices in one point; a triangle seen edge-on.
  const Mesh dot{*Topology::make(3, {{0, 1, 2}}), std::vector<double>(9, 4.0)};
  draw({{.meshes = {dot.picture()}}}, settings);
  const Mesh side{*Topology::make(3, {{0, 1, 2}}), {0, 0, 0, 0, 1, 0, 0, 0, 1}};
  draw({{.meshes = {side.picture()}, .view = kFlat}}, settings);
  const Mesh far{*Topology::make(3, {{0, 1, 2}}), {1e100, 0, 0, 2e100, 0, 0, 1e100, 1e100, 0}};
  EXPECT_NE(at(draw({{.meshes = {far.picture()}}}, settings), 6, 13), colors::kWhite);
}

TEST(Picture, RefusesInvalidInput) {
  const Mesh wall = square(1, 0);
  const auto problem = [](std::vector<Panel> panels, const PictureSettings& settings = {}) {
    const auto image = draw_picture(panels, settings);
    return image ? std::string() : image.error().line();
  };
  EXPECT_THAT(problem({}), HasSubstr("no panel"));
  for (const PictureSettings& bad : std::vector<PictureSettings>{
           {.width = 0}, {.height = 0}, {.width = 20000}, {.width = 16000, .height = 16000}}) {
    EXPECT_THAT(problem({{.meshes = {wall.picture()}}}, bad), HasSubstr("pixels cannot be draw"));
  }
  EXPECT_THAT(problem({{.meshes = {wall.picture()}}}, {.samples = 0}), HasSubstr("samples"));
  EXPECT_THAT(problem(std::vector<Panel>(9), {.width = 2, .height = 2}), HasSubstr("do not fit"));
  Mesh bad = wall;
  bad.x[4] = std::nan("");
  EXPECT_THAT(problem({{.meshes = {bad.picture()}}}), HasSubstr("not finite"));
  bad.x.pop_back();
  EXPECT_THAT(problem({{.meshes = {bad.picture()}}}), HasSubstr("number of positions"));
  bad = wall;
  bad.x[0] = 1e200;
  EXPECT_THAT(problem({{.meshes = {bad.picture()}}}), HasSubstr("too large"));
  PictureMesh colored = wall.picture();
  const std::vector<Color> three(3);
  colored.face_colors = three;
  EXPECT_THAT(problem({{.meshes = {colored}}}), HasSubstr("colors"));
  EXPECT_THAT(problem({{.meshes = {wall.picture()}, .view = {.from = {0, 0, 0}}}}), HasSubstr("direction"));
  EXPECT_THAT(problem({{.meshes = {wall.picture()}, .view = {.from = {0, 2, 0}}}}), HasSubstr("direction"));
  EXPECT_THAT(problem({{.meshes = {wall.picture()}, .view = {.focus = View::Focus{{0, 0, 0}, 0}}}}),
              HasSubstr("extent"));
  EXPECT_THAT(problem({{.meshes = {wall.picture()}, .view = {.fit = Eigen::AlignedBox3d()}}}),
              HasSubstr("finite box"));
  EXPECT_THAT(problem({{.points = {{{{0, 0, 0}}, colors::kRed, 0}}}}), HasSubstr("size for points"));
  EXPECT_THAT(problem({{.points = {{{{0, INFINITY, 0}}}}}}), HasSubstr("not finite"));
}

TEST(PictureView, IsParsed) {
  EXPECT_EQ(parse_view("front")->from, Vec3(0, 0, 1));
  EXPECT_EQ(parse_view("back")->from, Vec3(0, 0, -1));
  EXPECT_EQ(parse_view("side")->from, Vec3(1, 0, 0));
  EXPECT_EQ(parse_view("top")->up, Vec3(0, 0, -1));
  EXPECT_EQ(parse_view("1,-2.5,1e1")->from, Vec3(1, -2.5, 10));
  EXPECT_EQ(parse_view("front", Up::Z)->from, Vec3(0, -1, 0));
  EXPECT_EQ(parse_view("front", Up::Z)->up, Vec3(0, 0, 1));
  EXPECT_EQ(parse_view("side", Up::Z)->from, Vec3(1, 0, 0));
  EXPECT_EQ(parse_view("top", Up::Z)->from, Vec3(0, 0, 1));
  EXPECT_EQ(parse_view("top", Up::Z)->up, Vec3(0, 1, 0));
  EXPECT_EQ(parse_view("1,-2.5,1e1", Up::Z)->from, Vec3(1, -2.5, 10));
  EXPECT_TRUE(
      draw_picture(std::vector<Panel>{{.view = *parse_view("0,0,-3", Up::Z)}}, {.width = 4, .height = 4}));
  EXPECT_TRUE(draw_picture(std::vector<Panel>{{.view = *parse_view("0,-3,0")}}, {.width = 4, .height = 4}));
  for (const char* bad : {"", "left", "1,2", "1,2,3,4", "0,0,0", "1,2,x", "nan,0,1", "1,inf,0"}) {
    const auto view = parse_view(bad);
    ASSERT_FALSE(view) << bad;
    EXPECT_THAT(view.error().line(), HasSubstr("--view"));
  }
}

}  // namespace
}  // namespace foldproof
