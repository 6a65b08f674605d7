#include "reading.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "rules.hpp"
#include "values.hpp"

namespace checker {
namespace {

constexpr std::size_t MOST_CELLS = 60'000, MOST_PLACES = 1'000'000;
constexpr double LARGEST_EXCESS = 1e-3;
constexpr double MOST_PRODUCTS = 20e6;

Curve read_curve(Where where, nb::handle value) {
  const Fields fields(where, value, {"coordinates", "times", "values"});
  Curve found;
  for (nb::handle each : items(where, fields["coordinates"], MOST_JOINTS)) found.names.push_back(text("a coordinate", each));
  found.times = numbers("times", fields["times"]);
  const auto& times = found.times;
  const bool ordered = 2 <= times.size() && times.size() <= MOST_KNOTS && times[0] == 0.0 && std::is_sorted(times.begin(), times.end());
  demand(ordered, std::string("the times of ") + where + " must increase from 0, and be 2 to 20000");
  for (nb::handle order : items(where, fields["values"], 3)) {
    std::vector<double>& flat = found.values.emplace_back();
    for (nb::handle each : row(where, order, times.size()))
      for (nb::handle entry : row(where, each, found.names.size())) flat.push_back(number(where, entry));
  }
  const bool whole = found.values.size() >= 2 && !found.names.empty();
  demand(whole, std::string(where) + " needs positions and velocities of each coordinate at each time");
  return found;
}

Joint read_joint(nb::handle value, int coordinates, int joints) {
  const Fields fields("a joint", value, {"name", "place", "turns", "axis", "coordinate", "factor", "offset", "lower", "upper",
                                         "velocity", "acceleration", "jerk"});
  Joint found;
  found.name = text("the name of a joint", fields["name"]);
  found.place = place("the place of a joint", fields["place"], joints);
  found.turns = flag("turns", fields["turns"]);
  found.axis = normalised(direction<3>("the axis of a joint", fields["axis"]));
  found.coordinate = below("the coordinate of a joint", fields["coordinate"], coordinates);
  found.factor = number("factor", fields["factor"]), found.offset = number("offset", fields["offset"]);
  found.lower = unless_null("lower", fields["lower"], -INFINITY), found.upper = unless_null("upper", fields["upper"], INFINITY);
  Where names[] = {"velocity", "acceleration", "jerk"};
  for (int at = 0; at < 3; ++at) found.rates[at] = unless_null(names[at], fields[names[at]], INFINITY);
  return found;
}

Ends read_ends(nb::handle value, std::size_t count) {
  const Fields fields("ends", value, {"positions", "velocities", "accelerations", "tolerance", "speed", "rests"});
  const auto state = [&](Where name) {
    auto found = numbers(name, fields[name]);
    demand(found.size() == count, std::string(name) + " of the ends must be as many as the coordinates");
    return found;
  };
  return {state("positions"), state("velocities"), state("accelerations"), size("tolerance", fields["tolerance"]),
          size("speed", fields["speed"]), flag("rests", fields["rests"])};
}

Shape read_hull(nb::handle value) {
  const Fields fields("a hull", value, {"kind", "vertices", "radius"});
  Shape found;
  found.radius = size("the radius of a hull", fields["radius"]);
  for (nb::handle each : items("vertices", fields["vertices"])) {
    const auto at = tuple<3>("a vertex", each);
    found.x.push_back(at[0]), found.y.push_back(at[1]), found.z.push_back(at[2]);
    found.farthest = larger(found.farthest, Vec{at[0], at[1], at[2]}.middle());
  }
  demand(!found.x.empty(), "a hull needs vertices");
  found.vertices = static_cast<int>(found.x.size());
  while (found.x.size() % 4) found.x.push_back(found.x.back()), found.y.push_back(found.y.back()), found.z.push_back(found.z.back());
  return found;
}

Shape read_shape(nb::handle value) {
  const std::string kind = text("the kind of a shape", mapping("a shape", value).get("kind", nb::none()));
  if (kind == "hull") return read_hull(value);
  Shape found;
  if (kind == "frustum") {
    const Fields fields("a frustum", value, {"kind", "bottom", "top", "length"});
    found.kind = Shape::FRUSTUM;
    found.bottom = size("bottom", fields["bottom"]), found.top = size("top", fields["top"]), found.length = size("length", fields["length"]);
    return found;
  }
  demand(kind == "half-space", "the kind of a shape must be one of hull, frustum, half-space");
  const Fields fields("a half-space", value, {"kind"});
  found.kind = Shape::HALF_SPACE;
  return found;
}

// A sphere around a shape, in the shape's own frame.
std::pair<Vec, double> sphere(const Shape& shape) {
  if (shape.kind == Shape::HALF_SPACE) return {};
  if (shape.kind == Shape::FRUSTUM) return {Vec{}, Vec{larger(shape.bottom, shape.top), shape.length / 2.0}.length()};
  const auto middle = [](const std::vector<double>& of) {
    const auto [least, most] = std::minmax_element(of.begin(), of.end());
    return (*least + *most) / 2.0;
  };
  const Vec centre{middle(shape.x), middle(shape.y), middle(shape.z)};
  double reach = 0.0;
  for (std::size_t at = 0; at < shape.x.size(); ++at) reach = larger(reach, (Vec{shape.x[at], shape.y[at], shape.z[at]} - centre).length());
  return {centre, up(reach + shape.radius)};
}

Part read_part(nb::handle value, int joints) {
  const Fields fields("a part", value, {"owner", "place", "shape"});
  Part found{text("an owner", fields["owner"]), place("the place of a part", fields["place"], joints), read_shape(fields["shape"]), {}, 0.0};
  const auto [centre, radius] = sphere(found.shape);
  found.centre = found.place.translation + turned(found.place.rotation, centre), found.radius = radius;
  return found;
}

Change read_change(nb::handle value) {
  const nb::list entries = row("a change", value, 4);
  return {text("an owner", entries[0]), unless_null("appears", entries[1], -INFINITY), unless_null("expires", entries[2], INFINITY),
          tuple<3>("the error of a change", entries[3], 0.0)};
}

// Numbers of a witness, one after the other.
class Bytes {
 public:
  explicit Bytes(const std::string& data) : data_(data) {}
  template <class T>
  T take() {
    demand(at_ + sizeof(T) <= data_.size(), "the witness is shorter than its numbers of times and leaves");
    T found;
    std::memcpy(&found, data_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return found;
  }
  std::size_t left() const { return data_.size() - at_; }

 private:
  const std::string& data_;
  std::size_t at_ = 0;
};

std::vector<double> grid_of(Bytes& bytes, const Statement& statement) {
  std::vector<double> grid = statement.curve.times;
  const double end = grid.back();
  for (auto count = bytes.take<std::uint32_t>(); count; --count) {
    const double time = bytes.take<double>();
    demand(0.0 < time && time < end, "a time of the witness is not within the motion");
    grid.push_back(time);
  }
  for (const Curve& drive : statement.drives)
    std::copy_if(drive.times.begin(), drive.times.end(), std::back_inserter(grid), [&](double time) { return time < end; });
  std::sort(grid.begin(), grid.end());
  grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
  const bool few = grid.size() <= MOST_CELLS && grid.size() * (1 + statement.joints.size()) <= MOST_PLACES;
  demand(few, "the witness has too many times");
  return grid;
}

}  // namespace

Statement read_statement(nb::handle value) {
  const Fields fields("the statement", value, {"title", "motion", "drives", "joints", "ends", "excess", "parts", "changes", "pairs",
                                               "excused", "contacts", "requirements", "judged"});
  Statement found;
  text("the title", fields["title"]);
  found.curve = read_curve("motion", fields["motion"]);
  const auto& times = found.curve.times;
  bool whole = std::adjacent_find(times.begin(), times.end()) == times.end();
  const int own = found.curve.count();
  int coordinates = own;
  for (nb::handle each : items("drives", fields["drives"], MOST_JOINTS)) {
    found.drives.push_back(read_curve("a drive", each));
    coordinates += found.drives.back().count();
    whole = whole && found.drives.back().times.back() >= times.back();
  }
  demand(whole, "the times of the motion must increase, and drives must last until its end");
  const nb::list joints = items("joints", fields["joints"], MOST_JOINTS);
  const int count = static_cast<int>(joints.size());
  for (nb::handle each : joints) {
    found.joints.push_back(read_joint(each, coordinates, count));
    const Joint& joint = found.joints.back();
    demand(joint.place.joint < static_cast<int>(found.joints.size()), "a joint must come after its parent");
    demand(joint.coordinate < own || std::isinf(joint.rates[2]), "a joint that follows time cannot have a limit of jerk");
  }
  found.ends = read_ends(fields["ends"], static_cast<std::size_t>(own));
  found.excess = size("excess", fields["excess"]);
  demand(found.excess <= LARGEST_EXCESS, "excess must be a number from 0 to 0.001");
  for (nb::handle each : items("parts", fields["parts"], MOST_PARTS)) found.parts.push_back(read_part(each, count));
  std::map<std::string, int> joint_of;
  for (const Part& part : found.parts)
    demand(joint_of.emplace(part.owner, part.place.joint).first->second == part.place.joint, "the parts of an owner must be on one joint");
  std::set<std::string> changed;
  for (nb::handle each : items("changes", fields["changes"])) {
    found.changes.push_back(read_change(each));
    demand(changed.insert(found.changes.back().owner).second, "an owner has two changes");
  }
  for (nb::handle each : items("pairs", fields["pairs"])) {
    const nb::list entries = row("a pair", each, 3);
    const long parts = static_cast<long>(found.parts.size());
    found.pairs.push_back({below("a part", entries[0], parts), below("a part", entries[1], parts), size("a clearance", entries[2])});
  }
  for (nb::handle each : items("excused", fields["excused"])) {
    const nb::list entries = row("an excuse", each, 3);
    demand(text("a reason", entries[2]).find_first_not_of(' ') != std::string::npos, "an excuse needs a reason");
    found.excused.emplace_back(text("an owner", entries[0]), text("an owner", entries[1]));
  }
  for (nb::handle each : items("contacts", fields["contacts"])) {
    const nb::list entries = row("a contact", each, 4);
    found.contacts.push_back({text("an owner", entries[0]), text("an owner", entries[1]), unless_null("since", entries[2], -INFINITY),
                              unless_null("until", entries[3], INFINITY)});
  }
  for (nb::handle each : items("judged", fields["judged"])) text("a judged fact", each);
  for (nb::handle each : items("requirements", fields["requirements"])) found.rules.push_back(read_rule(each, found));
  return found;
}

Witness read_witness(const std::string& data, const Statement& statement) {
  Bytes bytes(data);
  Witness found;
  found.grid = grid_of(bytes, statement);
  found.first = {0};
  const std::size_t pairs = statement.pairs.size();
  double products = 0.0;
  std::uint64_t total = 0;
  for (const Pair& pair : statement.pairs) {
    const auto count = bytes.take<std::uint32_t>();
    total += count;
    products += static_cast<double>(count) * (statement.parts[pair.one].shape.vertices + statement.parts[pair.other].shape.vertices);
    demand(count > 0, "the leaves of a pair must begin at the start, increase and reach the end");
    demand(total <= bytes.left() / 8, "the witness is shorter than its numbers of times and leaves");
    found.first.push_back(static_cast<int>(total));
  }
  demand(bytes.left() == 8 * total, "the witness is longer than its numbers of times and leaves");
  demand(products <= MOST_PRODUCTS, "the witness has too many leaves for the vertices of its parts");
  for (std::uint64_t leaf = 0; leaf < total; ++leaf) {
    found.begin.push_back(bytes.take<std::uint16_t>());
    std::array<double, 3> direction;
    for (double& each : direction) each = bytes.take<std::int16_t>();
    found.direction.push_back(direction);
  }
  for (std::size_t pair = 0; pair < pairs; ++pair)
    for (int leaf = found.first[pair]; leaf < found.first[pair + 1]; ++leaf) {
      const bool starts = leaf > found.first[pair] || found.begin[leaf] == 0;
      demand(starts && found.begin[leaf] < found.end(static_cast<int>(pair), leaf),
             "the leaves of a pair must begin at the start, increase and reach the end");
    }
  return found;
}

}  // namespace checker
