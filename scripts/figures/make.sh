#!/bin/sh
# Makes the figures of docs/figures, which follow those of Gamito (2009) by number.
#
#     scripts/figures/make.sh                  all of them
#     scripts/figures/make.sh gradient 3.14a   some of them
#
# Figures of a noise are made by `orogen noise` and share a folder, a picture is made by `orogen render`
# of the script with its number, or by `orogen topology` if it shows what a solid is connected with, a curve of
# a formula by examples/profiles.rs. Figures that need what this version does not have are named and left out.
set -u
cd "$(dirname "$0")/../.."
orogen=${OROGEN:-target/release/orogen}
out=${OUT:-docs/figures}
wanted=" $* "
mkdir -p "$out"

is_wanted() { [ "$wanted" = "  " ] || case $wanted in *" $1 "*) true ;; *) false ;; esac; }
left_out() { echo "$1: left out; $orogen could not make it" >&2; }

averages="--only autocovariance --only spectrum --only radial --only anisotropy"
plates="--only sample --only sphere $averages"

# noise NAME KIND OPTION...
noise() {
    number=$1
    shift
    is_wanted "$number" || return 0
    echo "$number: orogen noise $*"
    "$orogen" noise "$@" --seed 1 -o "$out/$number" || left_out "$number"
}

# picture NUMBER SCRIPT OPTION...
picture() {
    number=$1
    script=scripts/figures/$2.rhai
    shift 2
    is_wanted "$number" || return 0
    echo "$number: orogen render $script $*"
    "$orogen" render "$script" -o "$out/$number.png" "$@" || left_out "$number"
}

# topology NUMBER SCRIPT WHAT OPTION...
topology() {
    number=$1
    script=scripts/figures/$2.rhai
    what=$3
    shift 3
    is_wanted "$number" || return 0
    echo "$number: orogen topology $script --show $what $*"
    "$orogen" topology "$script" --show "$what" -o "$out/$number.png" "$@" > /dev/null || left_out "$number"
}

# Chapter 2: algebraic, blobby, distance and convolution surfaces; hypertexture, constructive geometry,
# deformation, metamorphosis; a terrain by displacement, and with a hypertexture on it.
picture 2.04 2.04
picture 2.05 2.05
picture 2.06 2.06
picture 2.07 2.07
picture 2.08 2.08
picture 2.09 2.09
picture 2.10 2.10
picture 2.11 2.11
picture 2.12 2.12
picture 2.18a 2.18 --set features=0
picture 2.18b 2.18 --set features=1

# Models: terrain by rescale-and-add and by the two models with statistics by altitude, ridges plain
# and deformed, ridges on a sphere.
picture 3.14a 3.14a
picture 3.14b 3.14b
picture 3.14c 3.14c
picture 3.15a 3.15a
picture 3.15b 3.15b
picture 3.17a 3.17 --set octaves=2
picture 3.17b 3.17 --set octaves=5
picture 3.17c 3.17 --set octaves=8

# Chapter 5: three hypertextures, and a surface without a Lipschitz bound.
picture 5.6a 5.6 --set noise=1
picture 5.6b 5.6 --set noise=2
picture 5.6c 5.6 --set noise=3
picture 5.10 5.10

# Chapter 6: the test pattern, plain and through a box and a cubic spline; details with more and more samples, and
# with splines of higher order; a wheel through a shutter and through a spline over time, slow and fast.
picture 6.7a 6.07 --set order=0 --samples 1
picture 6.7b 6.07 --set order=1
picture 6.7c 6.07 --set order=4
picture 6.8a 6.08 --set order=0 --samples 1
picture 6.8b 6.08 --samples 4
picture 6.8c 6.08 --samples 9
picture 6.8d 6.08
picture 6.9a 6.08 --set place=1 --set order=0 --samples 1
picture 6.9b 6.08 --set place=1 --set order=1
picture 6.9c 6.08 --set place=1
picture 6.9d 6.08 --set place=1 --set order=15
picture 6.11a 6.11 --time 0.2
picture 6.11b 6.11 --time 0.2 --set spline=1
picture 6.11c 6.11 --time 0.2 --set fast=1
picture 6.11d 6.11 --time 0.2 --set fast=1 --set spline=1

# Chapter 7: pictures on their way to the finished one, which has the plain number. 7.8 has two to five octaves; of 7.14 a
# part is asked for before the rest.
picture 7.5 7.05 --snapshots 32,16,4
picture 7.6 7.06 --snapshots 32,16,8
picture 7.7 7.07 --snapshots 32,16,4
picture 7.8a 7.07 --set octaves=2
picture 7.8b 7.07 --set octaves=3
picture 7.8c 7.07 --set octaves=4
picture 7.8d 7.07 --set octaves=5
picture 7.13 5.10 --snapshots 32,16,4
picture 7.14 7.14 --snapshots 16,8,4 --focus 200,88,96x64

# Chapter 8: a sphere that falls to pieces; what the pieces are connected with; the pieces in red, and gone. Of
# three octaves there are 7000 minima to find, and two or three minutes to wait.
picture 8.1a 8.1 --set amplitude=0.1
picture 8.1b 8.1 --set amplitude=0.3
picture 8.1c 8.1 --set amplitude=0.8
topology 8.7 8.7 network
topology 8.8a 8.8 triptych --set octaves=1
topology 8.8b 8.8 triptych --set octaves=2
topology 8.8c 8.8 triptych --set octaves=3 --samples 4

# A planet of which it is found out place by place: some minutes each.
topology 8.14 8.14 triptych --size 456x276
topology 8.15a 8.14 kept --set height=8e-4 --set slope=1.5 --size 456x276
topology 8.15b 8.14 kept --set height=1.6e-3 --set slope=3 --size 456x276

# Chapter 9: spheres that flow gently; a solid that falls to pieces, as it is and without the pieces; an overhang, and the
# ground before it grew; overhangs all over a ground. A minute or two each, the strongest flow some, overhangs ten.
picture 9.8a 9.08 --set alpha=0.1 --size 400x400
picture 9.9a 9.09 --set alpha=0.01 --size 400x400
picture 9.9b 9.09 --set alpha=0.025 --size 400x400
picture 9.9c 9.09 --set alpha=0.04 --size 400x400
picture 9.11a 9.11 --set flowing=off --set whole=off
picture 9.11c 9.11 --set flowing=off
picture 9.12a 9.12 --size 228x138
picture 9.13 9.13 --size 200x150
picture 9.14 9.13 --set cone=1

# Strong flows, and flows of detail, take hours in all: only if they are asked for.
if [ "$wanted" != "  " ]; then
    picture 9.8b 9.08 --set alpha=0.5 --size 200x200
    picture 9.10a 9.10 --set alpha=0.1 --caster bent --size 200x200
    picture 9.10b 9.10 --size 200x200
    picture 9.11b 9.11 --set whole=off --size 200x200
    picture 9.11d 9.11 --size 200x200
    picture 9.12b 9.12 --set octaves=5 --size 114x69
fi

# The kernels: 4.4 the quintic fade, 4.9 the kernels of sparse convolution.
if is_wanted 4.04 || is_wanted 4.09; then
    cargo run --quiet --release --example profiles -- "$out"
fi

# Filters of pictures.
if is_wanted 6.05 || is_wanted 6.06 || is_wanted 6.10; then
    cargo run --quiet --release --example filters -- "$out"
fi

# Which nodes a point depends on, by noise; and the creases of sparse convolution with a linear kernel.
picture 4.03 4.03
picture 4.08 4.08
picture 4.13 4.13
picture 4.14 4.14

# 4.5 to 4.7, gradient noise: samples, covariance and spectrum, radial power and anisotropy.
noise gradient gradient $plates

# 4.10 to 4.12, sparse convolution noise, one node a cell. Its spectrum is shown in space: that of a
# plane is summed up across the plane, which fills the dark rings.
sparse="sparse --set nodes=1 --set kernel=quintic"
noise sparse $sparse --seeds 2 --only sample --only sphere
noise sparse $sparse --solid --cells 16 --samples 8 $averages

# 4.15 to 4.17, cellular noise of the nearest node; 4.18 and 4.19, of the two nearest, by Euclidean
# and by Manhattan distance.
noise cellular cellular --set weights=[1,0,0,0] --set centred=false $plates
noise cellular-two cellular --set weights=[1,1,0,0] --amplitude 0.05 --only sphere
noise cellular-manhattan cellular --set weights=[1,1,0,0] --set norm=manhattan --amplitude 0.03 --only sphere
