"""Renders scenes pass by pass, with the noise known at any time, and the pictures that guide a denoiser."""
