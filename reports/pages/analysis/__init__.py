"""What results say of accuracy and cost, in numbers."""
