// A model is refused with one line, or it is a model: then it can be saved and read again, and it changes no
// answer.
#include <cstring>

#include "file_target.h"
#include "foldproof/check.h"
#include "foldproof/model.h"

namespace {

/// The same collisions with and without the charts, in a step from nowhere in particular.
void require_same_answer(const foldproof::Model& model) {
  using namespace foldproof;
  std::vector<double> x0(std::size_t{3} * model.hierarchy()->topology().vertex_count()), x1 = x0;
  std::uint32_t random = 1;
  for (std::vector<double>* x : {&x0, &x1}) {
    for (double& c : *x) c = static_cast<double>((random = random * 1664525 + 1013904223) >> 24);
  }
  const std::span<const double> from[] = {x0}, to[] = {x1};
  StepResult with, without;
  if (!StepChecker({model.object()}).check(from, to, {}, with)) std::abort();
  if (!StepChecker({model.hierarchy()}).check(from, to, {.certificates = false}, without)) std::abort();
  if (with.vertex_face.size() != without.vertex_face.size()) std::abort();
  if (with.edge_edge.size() != without.edge_edge.size()) std::abort();
}

/// Whatever was learned may be used: numbers of any size, but none missing.
void use(const foldproof::Model& model) {
  using namespace foldproof;
  const Predictor predictor(model.learned);
  const Eigen::VectorXd keys = predictor.key_point_map().gather(model.learned->pca.mean);
  if (predictor.from_key_points(keys).size() != model.learned->pca.mean.size()) std::abort();
  if (const auto& map = model.learned->certificates) {
    if (map->margins(keys).size() != static_cast<Eigen::Index>(map->nodes.size())) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const foldproof::fuzz::ScratchFile file(".model"), copy("-copy.model");
  // Fuzzers seldom guess the size that stands in front.
  std::vector<char> bytes(data, data + size);
  const auto rest = static_cast<std::uint32_t>(size - 4);
  if (size >= 4) std::memcpy(bytes.data(), &rest, 4);
  file.write(bytes.data(), bytes.size());
  const auto model = foldproof::load_model(file.path());
  if (!model) {
    const foldproof::Error& error = model.error();
    if (error.where.empty() || error.problem.empty() || error.remedy.empty()) std::abort();
    return 0;
  }
  foldproof::summarize(*model);
  if (!foldproof::save_model(*model, copy.path()) || !foldproof::load_model(copy.path())) std::abort();
  if (model->hierarchy()->triangles().size() < 1000) require_same_answer(*model);
  if (model->learned) use(*model);
  return 0;
}
