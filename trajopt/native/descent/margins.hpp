// The distance that each pair of bodies must keep along a motion.
#pragma once

#include <algorithm>
#include <vector>

namespace descent {

// One number a pair everywhere, or one that tapers towards what fixed ends have; `TaperedMargins` and
// `ShrunkMargins` of trajopt.optimise.transcription.margins, which this is tested against, say what each is for.
struct Margins {
  std::vector<double> full;  // by pair, as all that follows; empty where margins do not taper
  std::vector<double> required, at_start, at_end, contact_until, contact_from, depth;
  std::vector<char> gives;   // whether less than the full margin will do
  double last = 0.0, taper = 1.0, share = 1.0;

  double operator()(std::size_t pair, double place) const {
    if (required.empty()) return full[pair];
    const double asked = tapered(pair, place);
    return gives[pair] && asked > required[pair] ? required[pair] + share * (asked - required[pair]) : asked;
  }

 private:
  double tapered(std::size_t pair, double place) const {
    if (place <= contact_until[pair] || place >= contact_from[pair]) return -depth[pair];
    const double since = std::clamp((place - std::max(contact_until[pair], 0.0)) / taper, 0.0, 1.0);
    const double until = std::clamp((std::min(contact_from[pair], last) - place) / taper, 0.0, 1.0);
    const double margin = std::min(at_start[pair] + (full[pair] - at_start[pair]) * since,
                                   at_end[pair] + (full[pair] - at_end[pair]) * until);
    return required[pair] > 0.0 ? std::max(margin, required[pair]) : margin;
  }
};

}  // namespace descent
