// Handlers of the page's requests.
#include "page/page.h"

#include <fmt/format.h>

#include <bit>
#include <optional>

#include "base/try.h"
#include "page/found_contacts.h"
#include "page/page_json.h"
#include "page/query.h"
#include "page/radius.h"
#include "page/repair.h"
#include "report/contact_pictures.h"

namespace foldproof {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are sent in native byte order");

PageAnswer json_answer(const Json& json) { return {.body = dump(json)}; }

template <class T>
PageAnswer binary_answer(std::span<const T> values) {
  return {
      200, "application/octet-stream", {reinterpret_cast<const char*>(values.data()), values.size_bytes()}};
}

/// Converts to single precision, which the page uses. Positions must be relative to a nearby point by then.
PageAnswer float_answer(std::span<const double> values, const Vec3& origin = Vec3::Zero()) {
  std::vector<float> floats;
  floats.reserve(values.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    floats.push_back(static_cast<float>(values[k] - origin[k % 3]));
  return binary_answer(std::span<const float>(floats));
}
PageAnswer vector_answer(const Eigen::Ref<const Eigen::VectorXd>& values, const Vec3& origin = Vec3::Zero()) {
  return float_answer(std::span(values.data(), static_cast<std::size_t>(values.size())), origin);
}

}  // namespace

struct Page::Impl {
  enum class State : std::uint8_t { Running, Done, Stopped, Failed };

  std::unique_ptr<SceneData> scene;
  std::unique_ptr<StepStore> store;
  std::unique_ptr<RadiusService> radii;
  std::unique_ptr<RepairService> repair;
  std::vector<std::unique_ptr<ReportWriter>> writers;
  std::optional<MotionCheck> check;  // until it has ended
  mutable std::mutex mutex;          // guards the following
  State state = State::Running;
  std::string failure;
  std::optional<CheckVerdict> verdict;              // none before the end of the check
  std::shared_ptr<const FoundContacts> found;       // null before the end of the check
  mutable std::mutex pictures_mutex;                // guards the following
  mutable std::optional<ContactPictures> pictures;  // for their views; none before the first

  // The numbers in a path, in order.
  using Numbers = std::span<const std::uint64_t>;
  using Handler = PageAnswer (Impl::*)(Numbers, const PageQuery&) const;

  PageAnswer scene_json(Numbers, const PageQuery&) const { return json_answer(scene->json()); }
  PageAnswer triangles(Numbers, const PageQuery&) const;
  PageAnswer frame(Numbers, const PageQuery&) const;
  PageAnswer boxes(Numbers, const PageQuery&) const;
  PageAnswer prediction(Numbers, const PageQuery&) const;
  PageAnswer mean(Numbers, const PageQuery&) const;
  PageAnswer mode(Numbers, const PageQuery&) const;
  PageAnswer radius(Numbers, const PageQuery&) const;
  PageAnswer steps(Numbers, const PageQuery&) const;
  PageAnswer crossings(Numbers, const PageQuery&) const;
  PageAnswer collisions(Numbers, const PageQuery&) const;
  PageAnswer faces(Numbers, const PageQuery&) const;
  PageAnswer contacts(Numbers, const PageQuery&) const;
  PageAnswer contact(Numbers, const PageQuery&) const;
  PageAnswer repair_status(Numbers, const PageQuery&) const { return json_answer(repair->status()); }
  PageAnswer repair_start(Numbers, const PageQuery&) const;
  PageAnswer repair_cancel(Numbers, const PageQuery&) const;
  PageAnswer repair_contacts(Numbers, const PageQuery& query) const;
  PageAnswer repair_report(Numbers, const PageQuery&) const;
  PageAnswer repaired_frame(Numbers, const PageQuery&) const;
  PageAnswer repaired_file(Numbers, const PageQuery&) const;

  const PageObject& object(std::uint64_t i) const { return *scene->objects()[i]; }
  std::optional<PageAnswer> missing_object(std::uint64_t i) const;
  std::optional<PageAnswer> missing_frame(std::uint64_t k) const;
  std::optional<PageAnswer> missing_modes(std::uint64_t object) const;
  std::optional<PageAnswer> missing_start() const;
  std::optional<PageAnswer> missing_step(std::uint64_t number) const;
  PageAnswer not_yet(const std::string& what) const;
  tl::expected<std::shared_ptr<const FoundContacts>, PageAnswer> contacts_found() const;
  tl::expected<std::shared_ptr<const FoundContacts>, PageAnswer> contacts_found_with(std::uint64_t k) const;
  Result<View> view_of_contact(const Contact& contact, Up up) const;
  bool advance(const std::atomic<bool>& stop);
  void end_check(State end, std::string line);
};

namespace {

/// Adds the steps of a check to the store.
class StoreWriter final : public ReportWriter {
 public:
  explicit StoreWriter(StepStore& store) : store_(store) {}
  Result<void> start(const CheckedStep& pose) override { return store_.start(pose); }
  Result<void> step(const CheckedStep& step) override { return store_.add(step); }
  Result<void> finish(const CheckTotals&) override { return {}; }

 private:
  StepStore& store_;
};

}  // namespace

std::optional<PageAnswer> Page::Impl::missing_object(std::uint64_t i) const {
  if (i < scene->objects().size()) return std::nullopt;
  return refuse(404, fmt::format("there is no object {} among {}", i, scene->objects().size()));
}

std::optional<PageAnswer> Page::Impl::missing_frame(std::uint64_t k) const {
  if (k < scene->frames().size()) return std::nullopt;
  return refuse(404, fmt::format("there is no frame {} among {}", k, scene->frames().size()));
}

std::optional<PageAnswer> Page::Impl::missing_modes(std::uint64_t i) const {
  if (auto answer = missing_object(i)) return answer;
  const Learned* learned = object(i).learned();
  if (learned != nullptr && learned->pca.modes() > 0) return std::nullopt;
  return refuse(404, fmt::format("object {} has no model that learned its shapes", i));
}

std::optional<PageAnswer> Page::Impl::missing_step(std::uint64_t number) const {
  if (number < store->count()) return std::nullopt;
  if (number >= scene->steps())
    return refuse(404, fmt::format("there is no step {} among {}", number, scene->steps()));
  return not_yet(fmt::format("step {}", number));
}

std::optional<PageAnswer> Page::Impl::missing_start() const {
  if (store->started()) return std::nullopt;
  if (scene->settings().poses) return refuse(404, "with --static, steps say what crosses in each frame");
  if (scene->settings().steps_only)
    return refuse(404, "crossings in the first frame were not tested (--steps-only)");
  return not_yet("the first frame");
}

PageAnswer Page::Impl::not_yet(const std::string& what) const {
  const std::lock_guard lock(mutex);
  if (state == State::Failed) return refuse(404, failure);
  if (state == State::Stopped) return refuse(404, "the check was stopped before " + what);
  return refuse(425, what + " is not checked yet");
}

PageAnswer Page::Impl::triangles(Numbers n, const PageQuery&) const {
  if (auto answer = missing_object(n[0])) return *answer;
  return binary_answer(object(n[0]).motion->topology().triangles());
}

PageAnswer Page::Impl::frame(Numbers n, const PageQuery&) const {
  if (auto answer = missing_object(n[0])) return *answer;
  if (auto answer = missing_frame(n[1])) return *answer;
  const auto x = scene->frame(static_cast<Index>(n[0]), static_cast<Index>(n[1]));
  return x ? float_answer(**x, scene->center()) : refuse(x.error());
}

PageAnswer Page::Impl::boxes(Numbers n, const PageQuery& query) const {
  if (auto answer = missing_object(n[0])) return *answer;
  const auto k = number_of(query, "frame", 0), level = number_of(query, "level", 0);
  if (!k) return no_number("frame");
  if (!level) return no_number("level");
  if (auto answer = missing_frame(*k)) return *answer;
  if (*level > object(n[0]).levels)
    return refuse(404, fmt::format("the deepest level is {}", object(n[0]).levels));
  const auto boxes =
      scene->boxes(static_cast<Index>(n[0]), static_cast<Index>(*k), static_cast<Index>(*level));
  return boxes ? binary_answer(std::span<const float>(*boxes)) : refuse(boxes.error());
}

PageAnswer Page::Impl::prediction(Numbers n, const PageQuery&) const {
  if (auto answer = missing_modes(n[0])) return *answer;
  if (auto answer = missing_frame(n[1])) return *answer;
  const auto x = scene->frame(static_cast<Index>(n[0]), static_cast<Index>(n[1]));
  if (!x) return refuse(x.error());
  const Predictor& predictor = object(n[0]).predictor();
  const Eigen::Map<const Eigen::VectorXd> pose((*x)->data(), static_cast<Eigen::Index>((*x)->size()));
  return vector_answer(predictor.from_key_points(predictor.key_point_map().gather(pose)), scene->center());
}

PageAnswer Page::Impl::mean(Numbers n, const PageQuery&) const {
  if (auto answer = missing_modes(n[0])) return *answer;
  return vector_answer(object(n[0]).learned()->pca.mean, scene->center());
}

PageAnswer Page::Impl::mode(Numbers n, const PageQuery&) const {
  if (auto answer = missing_modes(n[0])) return *answer;
  const Pca& pca = object(n[0]).learned()->pca;
  if (n[1] >= pca.modes()) return refuse(404, fmt::format("there is no mode {} among {}", n[1], pca.modes()));
  return vector_answer(pca.basis.col(static_cast<Eigen::Index>(n[1])));
}

PageAnswer Page::Impl::radius(Numbers n, const PageQuery&) const {
  if (auto answer = missing_modes(n[0])) return *answer;
  return json_answer(radii->request(static_cast<Index>(n[0])));
}

PageAnswer Page::Impl::steps(Numbers, const PageQuery& query) const {
  constexpr std::array<const char*, 4> kStates{"running", "done", "stopped", "failed"};
  const auto from = number_of(query, "from", 0);
  if (!from) return no_number("from");
  Json json;
  {
    // Read the state before the count: once it is "done", all steps are in the store.
    const std::lock_guard lock(mutex);
    json = {{"state", kStates[static_cast<std::size_t>(state)]}, {"error", failure}};
    json["verdict"] = verdict ? verdict_json(*verdict) : Json(nullptr);
  }
  const std::uint64_t done = store->count();
  const auto start = store->started();
  json["start"] = start ? start_json(*start) : Json(nullptr);
  json["done"] = done;
  json["total"] = scene->steps();
  Json& list = json["steps"] = Json::array();
  for (std::uint64_t k = *from; k < done && list.size() < kMaxItems; ++k) {
    const auto step = store->record(k);
    if (!step) return refuse(step.error());
    const auto bounds = store->bounds(k);
    if (!bounds) return refuse(bounds.error());
    list.push_back(step_json(*step));
    list.back()["low"] = bounds->low;
    list.back()["high"] = bounds->high;
  }
  return json_answer(json);
}

PageAnswer Page::Impl::crossings(Numbers, const PageQuery& query) const {
  if (auto answer = missing_start()) return *answer;
  const auto part = part_of(query);
  if (!part) return part.error();
  const auto crossings = store->crossings(part->offset, part->limit);
  if (!crossings) return refuse(crossings.error());
  Json items = Json::array();
  for (const ContactPoint& crossing : *crossings) items.push_back(contact_json(crossing));
  return json_answer({{"total", store->started()->crossings}, {"items", std::move(items)}});
}

PageAnswer Page::Impl::collisions(Numbers n, const PageQuery& query) const {
  if (auto answer = missing_step(n[0])) return *answer;
  const auto part = part_of(query);
  if (!part) return part.error();
  const auto step = store->record(n[0]);
  if (!step) return refuse(step.error());
  const auto contacts = store->contacts(n[0], part->offset, part->limit);
  if (!contacts) return refuse(contacts.error());
  Json items = Json::array();
  for (const ContactPoint& contact : *contacts) items.push_back(contact_json(contact));
  return json_answer({{"total", step->collisions.sum()}, {"items", std::move(items)}});
}

PageAnswer Page::Impl::faces(Numbers n, const PageQuery&) const {
  if (auto answer = missing_object(n[1])) return *answer;
  if (auto answer = missing_step(n[0])) return *answer;
  const auto faces = store->faces(n[0], static_cast<Index>(n[1]));
  if (!faces) return refuse(faces.error());
  PageAnswer answer{200, "application/octet-stream", {}};
  for (const auto part : {&FaceRecord::marks, &FaceRecord::reason})
    for (const FaceRecord& face : *faces) answer.body.push_back(static_cast<char>(face.*part));
  for (const FaceRecord& face : *faces) answer.body.push_back(static_cast<char>(face.level));
  for (const FaceRecord& face : *faces) answer.body.push_back(static_cast<char>(face.margin));
  return answer;
}

tl::expected<std::shared_ptr<const FoundContacts>, PageAnswer> Page::Impl::contacts_found() const {
  {
    const std::lock_guard lock(mutex);
    if (found) return found;
  }
  return tl::unexpected(not_yet("the last step, so what the contacts are"));
}

PageAnswer Page::Impl::contacts(Numbers, const PageQuery& query) const {
  const auto all = contacts_found();
  if (!all) return all.error();
  const auto part = part_of(query);
  if (!part) return part.error();
  return json_answer((*all)->json(part->offset, part->limit));
}

tl::expected<std::shared_ptr<const FoundContacts>, PageAnswer> Page::Impl::contacts_found_with(
    std::uint64_t k) const {
  auto all = contacts_found();
  if (!all) return all;
  const std::size_t count = (*all)->contacts.size();
  if (k >= count)
    return tl::unexpected(refuse(404, fmt::format("there is no contact {} among {}", k, count)));
  return all;
}

PageAnswer Page::Impl::contact(Numbers n, const PageQuery& query) const {
  const auto all = contacts_found_with(n[0]);
  if (!all) return all.error();
  Json json = (*all)->json(n[0]);
  const auto up = query.find("up");
  const auto view =
      view_of_contact((*all)->contacts[n[0]], up != query.end() && up->second == "z" ? Up::Z : Up::Y);
  if (!view) return refuse(view.error());
  json["view"] = {view->from.x(), view->from.y(), view->from.z()};
  return json_answer(json);
}

Result<View> Page::Impl::view_of_contact(const Contact& contact, Up up) const {
  const std::lock_guard lock(pictures_mutex);
  if (!pictures) pictures = FOLDPROOF_TRY(ContactPictures::open(scene->motions(), scene->settings()));
  return pictures->view(contact, up);
}

PageAnswer Page::Impl::repair_start(Numbers, const PageQuery& query) const {
  RepairChoice choice;
  const auto objects = numbers_of(query, "fixed"), parts = numbers_of(query, "parts"),
             contacts = numbers_of(query, "contact");
  for (const auto* list : {&objects, &parts, &contacts}) {
    if (!*list) return list->error();
  }
  for (const std::uint64_t number : *objects) {
    if (auto answer = missing_object(number)) return *answer;
    choice.fixed.push_back(static_cast<Index>(number));
  }
  const auto known = scene->parts();
  for (const std::uint64_t number : *parts) {
    if (number >= known.size()) return refuse(404, fmt::format("there is no part {}", number));
    choice.fixed_parts.push_back(known[number]);
  }
  std::vector<Index> counts;
  for (const auto& each : scene->objects()) counts.push_back(each->motion->topology().vertex_count());
  auto vertices = vertices_of(query, "vertices", counts);
  if (!vertices) return vertices.error();
  choice.fixed_vertices = std::move(*vertices);
  if (!contacts->empty()) {
    const auto all = contacts_found_with(contacts->front());
    if (!all) return all.error();
    choice.contact = (*all)->contacts[contacts->front()];
  }
  repair->start(std::move(choice));
  return json_answer(repair->status());
}

PageAnswer Page::Impl::repair_cancel(Numbers, const PageQuery&) const {
  repair->cancel();
  return json_answer(repair->status());
}

PageAnswer Page::Impl::repair_contacts(Numbers, const PageQuery& query) const {
  const auto part = part_of(query);
  if (!part) return part.error();
  const auto contacts = repair->contacts(part->offset, part->limit);
  return contacts ? json_answer(*contacts) : refuse(404, contacts.error().line());
}

PageAnswer Page::Impl::repair_report(Numbers, const PageQuery&) const {
  auto bytes = repair->report();
  return bytes ? PageAnswer{200, "text/html; charset=utf-8", std::move(*bytes)}
               : refuse(404, bytes.error().line());
}

PageAnswer Page::Impl::repaired_frame(Numbers n, const PageQuery&) const {
  if (auto answer = missing_object(n[0])) return *answer;
  if (auto answer = missing_frame(n[1])) return *answer;
  const auto x = repair->frame(static_cast<Index>(n[0]), static_cast<Index>(n[1]));
  return x ? float_answer(*x, scene->center()) : refuse(404, x.error().line());
}

PageAnswer Page::Impl::repaired_file(Numbers n, const PageQuery&) const {
  if (auto answer = missing_object(n[0])) return *answer;
  auto bytes = repair->file(static_cast<Index>(n[0]));
  return bytes ? PageAnswer{200, "application/octet-stream", std::move(*bytes)}
               : refuse(404, bytes.error().line());
}

void Page::Impl::end_check(State end, std::string line) {
  const std::lock_guard lock(mutex);
  state = end;
  failure = std::move(line);
}

bool Page::Impl::advance(const std::atomic<bool>& stop) {
  if (!check) return radii->compute_queued(stop) || repair->compute_queued(stop);
  if (stop) {
    check.reset();
    end_check(State::Stopped, {});
    return true;
  }
  const auto more = check->advance();
  if (more && *more) return true;
  if (!more) {
    end_check(State::Failed, more.error().line());
  } else {
    auto result = foldproof::verdict(scene->motions(), scene->settings(), check->totals());
    auto all = std::make_shared<const FoundContacts>(check->totals(), scene->motions(), scene->settings());
    const std::lock_guard lock(mutex);
    found = std::move(all);
    verdict = std::move(result);
    state = State::Done;
  }
  check.reset();
  return true;
}

Page::Page(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Page::~Page() = default;

Result<std::unique_ptr<Page>> Page::open(PageInput input) {
  auto impl = std::make_unique<Impl>();
  const auto writer = std::move(input.writer);
  RepairService::Context context{input.repair_progress, input.files, input.command};
  impl->scene = FOLDPROOF_TRY(SceneData::open(std::move(input)));
  impl->store = FOLDPROOF_TRY(StepStore::open(impl->scene->motions()));
  impl->radii = std::make_unique<RadiusService>(*impl->scene);
  impl->repair = std::make_unique<RepairService>(*impl->scene, std::move(context));
  impl->writers.push_back(std::make_unique<StoreWriter>(*impl->store));
  if (writer) impl->writers.push_back(FOLDPROOF_TRY(writer(impl->scene->motions(), impl->scene->settings())));
  impl->check =
      FOLDPROOF_TRY(MotionCheck::make(impl->scene->motions(), impl->scene->settings(), impl->writers));
  return std::unique_ptr<Page>(new Page(std::move(impl)));
}

PageAnswer Page::get(std::string_view path, const PageQuery& query) const {
  struct Route {
    std::string_view pattern;  // '#' matches a number
    Impl::Handler handler;
  };
  static const Route routes[] = {
      {"/api/scene", &Impl::scene_json},
      {"/api/objects/#/triangles", &Impl::triangles},
      {"/api/objects/#/frames/#", &Impl::frame},
      {"/api/objects/#/boxes", &Impl::boxes},
      {"/api/objects/#/prediction/#", &Impl::prediction},
      {"/api/objects/#/model/mean", &Impl::mean},
      {"/api/objects/#/model/modes/#", &Impl::mode},
      {"/api/objects/#/model/radius", &Impl::radius},
      {"/api/steps", &Impl::steps},
      {"/api/start/crossings", &Impl::crossings},
      {"/api/steps/#/collisions", &Impl::collisions},
      {"/api/steps/#/faces/#", &Impl::faces},
      {"/api/contacts", &Impl::contacts},
      {"/api/contacts/#", &Impl::contact},
      {"/api/repair", &Impl::repair_status},
      {"/api/repair/start", &Impl::repair_start},
      {"/api/repair/cancel", &Impl::repair_cancel},
      {"/api/repair/contacts", &Impl::repair_contacts},
      {"/api/repair/report", &Impl::repair_report},
      {"/api/objects/#/repaired/file", &Impl::repaired_file},
      {"/api/objects/#/repaired/#", &Impl::repaired_frame},
  };
  const auto parts = split(path, '/');
  for (const Route& route : routes) {
    const auto pattern = split(route.pattern, '/');
    if (pattern.size() != parts.size()) continue;
    std::vector<std::uint64_t> numbers;
    std::string_view bad;
    bool fits = true;
    for (std::size_t k = 0; k < pattern.size() && fits; ++k) {
      if (pattern[k] != "#") {
        fits = pattern[k] == parts[k];
      } else if (const auto number = number_in(parts[k])) {
        numbers.push_back(*number);
      } else {
        bad = parts[k];
        numbers.push_back(0);
      }
    }
    if (!fits) continue;
    return bad.data() != nullptr ? no_number(bad) : (impl_.get()->*route.handler)(numbers, query);
  }
  return refuse(404, "there is nothing here");
}

bool Page::advance(const std::atomic<bool>& stop) {
  try {
    return impl_->advance(stop);
  } catch (const std::exception& error) {
    impl_->check.reset();
    impl_->end_check(Impl::State::Failed, line_of(error));
    return true;
  }
}

void Page::work(const std::atomic<bool>& stop) {
  while (!stop) {
    if (!advance(stop)) impl_->radii->wait();
  }
  advance(stop);  // says that the check was stopped, if it was
}

}  // namespace foldproof
