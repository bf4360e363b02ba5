#include "firmware/identify/identifier.h"

#include "firmware/identify/quadruple_search.h"

namespace adit::identify {

struct Identifier::State {
  std::vector<QuadrupleSearch> searches;
  BlobGrid grid;
};

Identifier::Identifier(const std::vector<Model>& models, const IdentifierOptions& options)
    : state_(std::make_unique<State>()) {
  ADIT_REQUIRE(models.size() <= kMaxTargets);
  for (const Model& model : models) state_->searches.emplace_back(model, options);
}

Identifier::~Identifier() = default;
Identifier::Identifier(Identifier&&) noexcept = default;
Identifier& Identifier::operator=(Identifier&&) noexcept = default;

void Identifier::Identify(const detect::BlobSet& blobs, SightingSet& out) {
  out.blob_set = &blobs;
  out.sightings.clear();
  out.no_room = 0;
  out.cut_short = false;
  if (blobs.stamp.status != base::FrameStatus::kOk || blobs.blobs.empty()) return;
  state_->grid.Build(blobs);
  // Blobs looked at per target before a search gives up: about 2 ms. 400 lamps need some ten thousand; only a
  // screen full of glitter in one corner needs more.
  constexpr long kBudget = 1'000'000;
  for (std::size_t i = 0; i < state_->searches.size(); ++i) {
    long budget = kBudget;
    state_->searches[i].Run(state_->grid, static_cast<std::uint8_t>(i), budget, out);
  }
}

}  // namespace adit::identify
