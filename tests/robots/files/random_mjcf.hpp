#pragma once
#include <random>
#include <string>

#include <fmt/format.h>

namespace oncollide::test {

/// Random models in MJCF, without meshes and includes.
class RandomMjcf {
public:
    /// @param overlapping  all geoms are spheres that meet, of different radii
    RandomMjcf(unsigned seed, bool overlapping) : random_(seed), overlapping_(overlapping) {}

    std::string make()
    {
        in_degrees_ = chance(0.5), default_turns_ = !overlapping_ && chance(0.3);
        static constexpr const char* orders[] = {"xyz", "XYZ", "zyx", "ZxZ", "yXz"};
        std::string bodies;
        const int count = pick(3, 9);
        for (int i = 0; i < 2; ++i) bodies += geom("", false);
        for (int i = 0; bodies_ < count; ++i) bodies += body(count, 0);
        std::string contact;
        const auto add = [&](const char* kind, const char* side, const char* prefix, int most) {
            const int a = pick(0, most - 1), b = pick(0, most - 1);
            const std::string pair = fmt::format("{} {}", std::min(a, b), std::max(a, b));
            if (a == b || contact.find(fmt::format("<!--{}{}-->", prefix, pair)) != contact.npos) return;
            contact += fmt::format("<!--{0}{1}--><{2} {3}1='{0}{4}' {3}2='{0}{5}'/>\n", prefix, pair, kind, side, a, b);
        };
        for (int i = 0; i < 3; ++i) add("exclude", "body", "b", bodies_);
        if (chance(0.5))
            for (int i = 0; i < 2; ++i) add("pair", "geom", "g", geoms_);
        return fmt::format(R"(<mujoco model="random">
<compiler angle="{}" eulerseq="{}" autolimits="true" boundmass="0.1" boundinertia="0.1"/>
<size nconmax="2000"/>
<option><flag filterparent="{}"/></option>
<default>
  <geom contype="3" conaffinity="1" {}/>
  <joint axis="0 1 0" pos="0.1 0 0.2"/>
  <default class="outer"><geom conaffinity="6" size="0.3 0.2 0.1" {}/><joint type="slide" ref="0.5"/>
    <default class="inner"><geom contype="4" size="0.4" type="{}"/><joint axis="1 1 0" type="hinge" range="-1 2"/></default>
  </default>
  <default class="seen"><geom contype="0" conaffinity="0"/></default>
</default>
<worldbody>
{}</worldbody>
<contact>
{}</contact>
</mujoco>
)",
                           in_degrees_ ? "degree" : "radian", orders[pick(0, 4)], chance(0.8) ? "enable" : "disable",
                           overlapping_ ? "type=\"sphere\"" : "type=\"capsule\" size=\"0.1 0.3\"",
                           default_turns_ ? "euler=\"0.1 0.2 0.3\"" : "", overlapping_ ? "sphere" : "box", bodies,
                           contact);
    }
    int geoms() const { return geoms_; }
    double number(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }

    static double radius_of(int geom) { return 100 + 0.5 * geom; }

private:
    int pick(int low, int high) { return std::uniform_int_distribution(low, high)(random_); }
    bool chance(double share) { return number(0, 1) < share; }
    double angle() { return in_degrees_ ? number(-180, 180) : number(-3, 3); }
    std::string vector(double size = 1)
    {
        return fmt::format("{} {} {}", number(-size, size), number(-size, size), number(-size, size));
    }
    std::string pose()
    {
        std::string text = chance(0.8) ? fmt::format(" pos='{}'", vector()) : "";
        // Another orientation than the default's: versions of MuJoCo differ about which one counts.
        static constexpr int all[] = {0, 1, 2, 3, 4, 5}, alike[] = {0, 4, 5, 0, 4, 5};
        switch ((default_turns_ ? alike : all)[pick(0, 5)]) {
        case 0:
            return text + fmt::format(" quat='{} {}'", number(-1, 1), vector());
        case 1:
            return text + fmt::format(" axisangle='{} {}'", vector(), angle());
        case 2:
            return text + fmt::format(" xyaxes='{} {}'", vector(), vector());
        case 3:
            return text + fmt::format(" zaxis='{}'", chance(0.1) ? "0 0 -1" : vector());
        case 4:
            return text + fmt::format(" euler='{} {} {}'", angle(), angle(), angle());
        }
        return text;
    }
    std::string class_of() { return chance(0.3) ? (chance(0.5) ? " class='outer'" : " class='inner'") : ""; }

    std::string geom(const std::string& classes, bool moves)
    {
        std::string text = fmt::format("<geom name='g{}'{}", geoms_, chance(0.1) ? " class='seen'" : classes);
        if (overlapping_) {
            text += fmt::format(" type='sphere' size='{}' pos='{}'", radius_of(geoms_), vector());
        } else if (!moves && chance(0.5)) {
            text += fmt::format(" type='plane' size='0 0 1'{}", pose());
        } else if (chance(0.4)) {
            static constexpr const char* kinds[] = {"capsule", "cylinder", "box", "ellipsoid"};
            text += fmt::format(" type='{}' size='{}' fromto='{} {}'", kinds[pick(0, 3)], number(0.1, 1), vector(),
                                vector());
        } else if (chance(0.8)) {
            static constexpr const char* kinds[] = {"sphere", "capsule", "cylinder", "box", "ellipsoid"};
            text += fmt::format(" type='{}' size='{} {} {}'{}", kinds[pick(0, 4)], number(0.1, 1), number(0.1, 1),
                                number(0.1, 1), pose());
        } else {
            text += pose();
        }
        if (chance(0.4)) text += fmt::format(" contype='{}'", pick(0, 7));
        if (chance(0.4)) text += fmt::format(" conaffinity='{}'", pick(0, 7));
        ++geoms_;
        return text + "/>\n";
    }

    std::string joints(bool in_world)
    {
        if (in_world && chance(0.25)) return chance(0.5) ? "<freejoint/>\n" : "<joint type='free'/>\n";
        std::string text;
        for (int n = chance(0.2) ? 0 : pick(1, 3); n-- > 0;) {
            text += fmt::format("<joint{}{}", chance(0.5) ? fmt::format(" name='j{}'", joints_) : "", class_of());
            ++joints_;
            if (chance(0.5)) text += chance(0.5) ? " type='slide'" : " type='hinge'";
            if (chance(0.6)) text += fmt::format(" pos='{}'", chance(0.3) ? "0 0 0" : vector());
            if (chance(0.6)) text += fmt::format(" axis='{}'", vector(3));
            if (chance(0.3)) text += fmt::format(" ref='{}'", number(-1, 1));
            if (chance(0.3)) text += " range='-2 1.5'";
            if (chance(0.2)) text += " limited='false'";
            text += "/>\n";
        }
        return text;
    }

    std::string body(int most, int level)
    {
        const int number = bodies_++;
        std::string text = fmt::format("<body name='b{}'{}{}>\n<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>\n",
                                       number, pose(), chance(0.3) ? " childclass='outer'" : "");
        text += joints(level == 0);
        for (int n = pick(0, 3); n-- > 0;) text += geom(class_of(), true);
        for (int n = pick(0, 2); n-- > 0 && bodies_ < most;) text += body(most, level + 1);
        return text + "</body>\n";
    }

    std::mt19937 random_;
    const bool overlapping_;
    bool in_degrees_ = true, default_turns_ = false;
    int bodies_ = 0, geoms_ = 0, joints_ = 0;
};

} // namespace oncollide::test
