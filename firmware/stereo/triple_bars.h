// Bars of which three LEDs are seen in both images, and how far they are to be believed.
#pragma once

#include <bitset>
#include <vector>

#include "firmware/stereo/bar_builder.h"
#include "firmware/stereo/choice.h"
#include "firmware/stereo/other_readings.h"
#include "firmware/stereo/triple_search.h"

namespace adit::stereo {

/// Finds bars without a lock. Three points that stand right are strong evidence among scattered lamps and
/// weak evidence where lamps stand in rows. So a bar counts only if fewer than `options.chance_max` like it
/// are expected by chance from the density of the blobs, if its LEDs are alike in brightness and cannot be
/// read otherwise (OtherReadings), and, where other lights stand on its line, if its fourth LED is seen in
/// one image or something hides it in both, and the lights are no row at even steps. One thread; no
/// allocation after construction.
class TripleBars {
 public:
  TripleBars(const optics::Rig& rig, const std::vector<base::Target>& targets, const LocatorOptions& options);

  /// Adds to `findings`, by target, the bars of the targets `wanted`. What was found of these with four LEDs
  /// is dropped if it reflects lights that are seen (ReflectsLights), or is not alike and can be read
  /// otherwise. `builder` and `correspondence` have the pair set. The blobs of what was found with four LEDs
  /// are no part of anything else: no three of them would stand against it. Two lights that are `anothers`,
  /// of targets that are followed, are not taken for a bar's. Concludes nothing where the search is cut
  /// short.
  void Run(const std::bitset<identify::kMaxTargets>& wanted, const BarBuilder& builder,
           const Correspondence& correspondence, const BlobFlags& anothers, std::vector<Finding>& findings);

 private:
  struct Bar {
    Triple triple;
    Solution solution;
  };
  static constexpr std::size_t kMaxBars = 32;
  /// A light on a bar's line that is no LED of it.
  struct LineLight {
    double place_m = 0;  ///< from LED 1
    double flux_dn = 0;  ///< in the left image
  };
  /// Of six lights beside a triple nothing is concluded: nine lights are 84 triples, and each is 24 readings
  /// of three bars.
  using LineLights = base::FixedVector<LineLight, 6>;

  /// Where lights could be read in two ways, and when three LEDs last showed there. It lasts over pairs; one
  /// that finds no room is not remembered.
  struct Doubt {
    std::uint8_t target = 0;
    Eigen::Vector3d epicenter_b_m = Eigen::Vector3d::Zero();
    base::TimeNs seen_ns = base::kNever;
  };
  static constexpr std::size_t kMaxDoubts = 16;

  void DropDoubtful(std::size_t target, const BarBuilder& builder, Finding& finding) const;
  void Claim(const std::vector<Finding>& findings);
  void Try(const Triple& triple, const BarBuilder& builder, const std::vector<Finding>& findings);
  LineLights LightsInLine(const Bar& bar, const detect::BlobSet& left) const;
  bool IsRow(const Bar& bar, const LineLights& others) const;
  bool IsDark(const Bar& bar, const BarBuilder& builder, std::size_t side) const;
  bool StandsInItsLine(const Bar& bar, const BarBuilder& builder) const;
  bool IsAnothers(const Bar& bar) const;
  bool IsContested(const Bar& bar, const BarBuilder& builder) const;
  bool IsInDoubt(const Bar& bar, const BarBuilder& builder);

  std::vector<base::Target> targets_;
  optics::Rig rig_;
  Views views_;
  LocatorOptions options_;
  OtherReadings other_readings_;
  std::bitset<identify::kMaxTargets> wanted_;
  BlobFlags claimed_, anothers_;
  PointCloud cloud_;
  TripleSearch search_;
  TripleSet triples_;
  base::FixedVector<Bar, kMaxBars> bars_;
  base::FixedVector<Doubt, kMaxDoubts> doubts_;
};

}  // namespace adit::stereo
