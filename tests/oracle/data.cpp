#include "oracle/data.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace foldproof::oracle {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> result;
  std::stringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) result.push_back(field);
  return result;
}

double quotient(const std::string& numerator, const std::string& denominator) {
  using boost::multiprecision::cpp_int;
  const Rational exact(cpp_int{numerator}, cpp_int{denominator});
  const double value = exact.convert_to<double>();
  if (Rational(value) != exact)
    throw std::runtime_error("a query's coordinate is not a double: " + numerator);
  return value;
}

void read_query_file(const fs::path& csv, Kind kind, std::vector<Query>& queries) {
  std::ifstream in(csv);
  std::string line;
  for (int row = 0; std::getline(in, line); ++row) {
    const std::vector<std::string> f = fields(line);
    if (f.size() != 7) throw std::runtime_error(csv.string() + ": a row does not have seven fields");
    if (row % 8 == 0) {
      queries.push_back({kind, {}, {}, f[6][0] == '1', csv.string() + " query " + std::to_string(row / 8)});
    }
    FourPoints& x = row % 8 < 4 ? queries.back().x0 : queries.back().x1;
    x[row % 4] = Vec3(quotient(f[0], f[1]), quotient(f[2], f[3]), quotient(f[4], f[5]));
  }
}

}  // namespace

std::vector<Query> read_queries(const fs::path& data) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(data / "ccd-ground-truth" / "queries")) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Query> queries;
  for (const fs::path& file : files) {
    const bool vf = file.parent_path().filename() == "vertex-face";
    read_query_file(file, vf ? Kind::VertexFace : Kind::EdgeEdge, queries);
  }
  return queries;
}

std::vector<ListedPair> read_truth(const fs::path& csv) {
  std::ifstream in(csv);
  std::string line;
  std::getline(in, line);  // Names of the columns.
  std::vector<ListedPair> pairs;
  while (std::getline(in, line)) {
    const std::vector<std::string> f = fields(line);
    ListedPair pair;
    for (std::size_t i = 0; i + 1 < f.size(); ++i) pair.ids.push_back(static_cast<Index>(std::stoul(f[i])));
    pair.collides = f.back()[0] == '1';
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

std::unique_ptr<Motion> open_motion(const std::vector<std::string>& arguments) {
  auto motions = open_motions(arguments);
  if (!motions) throw std::runtime_error(motions.error().line());
  if (motions->size() != 1) throw std::runtime_error(arguments.front() + " is not one motion");
  return std::move(motions->front());
}

std::unique_ptr<Motion> open_real_motion(const fs::path& data, const std::string& name) {
  static const std::map<std::string, std::vector<const char*>> kFiles{
      {"lion_poses", {"lion-poses"}},
      {"lion_anim", {"lion-anim/lion-anim-loop1.obj", "lion-anim/lion-anim-loop1.pc2"}},
      {"hand_poses", {"hand/hand-poses.obj", "hand/hand-poses.pc2"}},
      {"hand_train", {"hand/hand-train.obj", "hand/hand-train.pc2"}},
      {"hand_anim", {"hand/hand-anim.obj", "hand/hand-anim.pc2"}},
      {"horse_poses", {"horse-poses"}},
      {"horse_gallop", {"horse-gallop/horse-gallop.obj", "horse-gallop/horse-gallop.pc2"}},
      {"elephant_poses", {"elephant/elephant-poses.obj", "elephant/elephant-poses.pc2"}},
      {"elephant_gallop", {"elephant/elephant-gallop.obj", "elephant/elephant-gallop.pc2"}},
      {"samba", {"samba/samba.obj", "samba/samba.pc2"}},
      {"rumba", {"rumba/rumba.obj", "rumba/rumba.pc2"}},
      // The ground truth keeps its frames beside lists of pairs.
      {"cloth_ball", {"ccd-ground-truth/cloth-ball/frame_*.ply"}},
      {"rod_twist", {"ccd-ground-truth/rod-twist/frame_*.ply"}},
      {"cloth_funnel", {"ccd-ground-truth/cloth-funnel/frame_*.ply"}},
  };
  std::vector<std::string> files;
  for (const char* file : kFiles.at(name)) files.push_back((data / file).string());
  return open_motion(files);
}

bool all_frames() {
  const char* all = std::getenv("FOLDPROOF_ALL_FRAMES");
  return all != nullptr && std::string(all) == "1";
}

}  // namespace foldproof::oracle
